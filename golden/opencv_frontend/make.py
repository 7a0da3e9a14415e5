# requirements: numpy, opencv-python-headless (versions used stand in the file it writes); the `images` data pack
"""Writes golden.json and the crops first.pgm, second.pgm: what OpenCV finds in a real image and follows into a warped one.

The first crop is the mean of five images of a camera at rest; the second is the same scene warped by a known similarity. Both get new
noise, as strong as the real images' (measured over the recording: variance .3 + .0145 grey values). Run in this folder:
python3 make.py [DATA]   (DATA: folder of the unpacked packs, default ../../data)
"""
import glob
import json
import sys

import cv2
import numpy as np

cv2.setNumThreads(1)
data = sys.argv[1] if len(sys.argv) > 1 else "../../data"
files = sorted(glob.glob(f"{data}/images/V1_01_easy_static/mav0/cam0/data/*.png"))[:5]
base = np.mean([cv2.imread(f, cv2.IMREAD_GRAYSCALE).astype(np.float64) for f in files], axis=0)
rng = np.random.default_rng(10)
W, H = 204, 156
X, Y = 480, 262  # the crop's corner: carpet, tape with bits of paper, a town plan, a chair


def noisy(image):
    noise = np.sqrt(0.3 + 0.0145 * np.clip(image, 0, 255)) * rng.standard_normal(image.shape)
    saturated = image >= 254.5
    return np.where(saturated, 255, np.clip(np.round(image + noise), 0, 255)).astype(np.uint8)


def warp(shift, angle_deg, scale):
    """Takes pixels of the whole first image to the second, about the crop's middle."""
    c, s = scale * np.cos(np.radians(angle_deg)), scale * np.sin(np.radians(angle_deg))
    A = np.array([[c, -s], [s, c]])
    middle = np.array([X + W / 2, Y + H / 2])
    return A, middle + np.array(shift) - A @ middle


def crop(image):
    return np.ascontiguousarray(image[Y : Y + H, X : X + W])


A, b = warp(shift=(3.37, -2.61), angle_deg=0.5, scale=1.004)
warped = cv2.warpAffine(base, np.column_stack([A, b]), (base.shape[1], base.shape[0]), flags=cv2.INTER_CUBIC)
first, second = noisy(crop(base)), noisy(crop(warped))
for name, image in (("first", first), ("second", second)):
    with open(f"{name}.pgm", "wb") as file:
        file.write(f"P5\n{W} {H}\n255\n".encode() + image.tobytes())

EDGE = 4  # on the outermost pixels OpenCV mirrors products of gradients, we mirror the image
inner = np.zeros((H, W), np.uint8)
inner[EDGE:-EDGE, EDGE:-EDGE] = 255
corners = cv2.goodFeaturesToTrack(first, 60, 0.01, 10, mask=inner).reshape(-1, 2)
few = cv2.goodFeaturesToTrack(first, 25, 0.05, 20, mask=inner).reshape(-1, 2)
mask = inner.copy()
mask[:, 100:] = 0
masked = cv2.goodFeaturesToTrack(first, 60, 0.01, 10, mask=mask).reshape(-1, 2)


def flow(levels, window):
    to, status, _ = cv2.calcOpticalFlowPyrLK(
        first, second, corners.reshape(-1, 1, 2), None, winSize=(window, window), maxLevel=levels - 1
    )
    to = to.reshape(-1, 2)
    return {"levels": levels, "window": window, "to": to.tolist(), "status": status.ravel().tolist()}


truth = (corners + [X, Y]) @ A.T + b - [X, Y]
flows = [flow(4, 21), flow(3, 21), flow(3, 15), flow(3, 29)]
for f in flows:
    error = np.array(f["to"]) - truth
    inside = ((truth > 12) & (truth < [W - 13, H - 13])).all(axis=1) & (np.array(f["status"]) == 1)
    inside &= np.linalg.norm(error, axis=1) < 1
    print(f["levels"], f["window"], inside.sum(), "inside, OpenCV's RMS per axis", np.sqrt((error[inside] ** 2).mean()))

pyramid = [cv2.pyrDown(first)]
pyramid.append(cv2.pyrDown(pyramid[0]))


def samples(image, n):
    at = rng.integers(0, [image.shape[1], image.shape[0]], (n, 2))
    return {"size": [image.shape[1], image.shape[0]], "at": at.tolist(), "grey": [int(image[y, x]) for x, y in at]}


json.dump(
    {
        "versions": {"python": sys.version.split()[0], "numpy": np.__version__, "opencv": cv2.__version__},
        "edge": EDGE,
        "corners": {"most": 60, "quality": 0.01, "distance": 10, "px": corners.tolist()},
        "few": {"most": 25, "quality": 0.05, "distance": 20, "px": few.tolist()},
        "masked": {"most": 60, "quality": 0.01, "distance": 10, "px": masked.tolist(), "free_columns": 100},
        "truth": truth.tolist(),
        "flows": flows,
        "pyramid": [samples(level, 150) for level in pyramid],
    },
    open("golden.json", "w"),
)
