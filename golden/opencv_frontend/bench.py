# requirements: numpy, opencv-python-headless; the `images` data pack
"""Times OpenCV's calcOpticalFlowPyrLK and goodFeaturesToTrack as VINS-Mono calls them: one thread, 21 x 21 px, levels 0 to 3 every image,
150 corners, quality .01, 30 px apart, with discs around tracks, every second image. The images of `bench/frames.rs`.

Run in this folder, in turn with `cargo bench -p dpn-bench --bench front_end`: python3 bench.py [DATA]
"""
import glob
import sys
import time

import cv2
import numpy as np

cv2.setNumThreads(1)
data = sys.argv[1] if len(sys.argv) > 1 else "../../data"
files = sorted(glob.glob(f"{data}/images/V1_01_easy_static/mav0/cam0/data/*.png"))[:40]
images = []
for i, file in enumerate(files):
    roll = (round(25 * np.sin(2 * np.pi * i / 25)), round(60 * np.sin(2 * np.pi * i / 40)))
    images.append(np.ascontiguousarray(np.roll(cv2.imread(file, cv2.IMREAD_GRAYSCALE), roll, axis=(0, 1))))

h, w = images[0].shape
prev, points = None, np.zeros((0, 1, 2), np.float32)
used = {"flow": 0.0, "corners": 0.0}  # CPU time
frames = tracked = 0
for number in range(11 * len(images)):
    image = images[number % len(images)]
    counts = number >= len(images)  # the first round does not count
    t0 = time.process_time()
    if prev is not None and len(points):
        to, status, _ = cv2.calcOpticalFlowPyrLK(prev, image, points, None, winSize=(21, 21), maxLevel=3)
        keep = (status.ravel() == 1) & (to[:, 0, :] >= 1).all(1) & (to[:, 0, 0] < w - 1) & (to[:, 0, 1] < h - 1)
        points = to[keep]
    t1 = time.process_time()
    if number % 2 == 0:
        mask = np.full((h, w), 255, np.uint8)
        chosen = []
        for (x, y), in points:
            if mask[int(y), int(x)]:
                chosen.append((x, y))
                cv2.circle(mask, (int(x), int(y)), 30, 0, -1)
        points = np.array(chosen, np.float32).reshape(-1, 1, 2)
        if len(points) < 150:
            new = cv2.goodFeaturesToTrack(image, 150 - len(points), 0.01, 30, mask=mask)
            if new is not None:
                points = np.concatenate([points, new])
    t2 = time.process_time()
    prev = image
    if counts:
        frames += 1
        tracked += len(points)
        used["flow"] += t1 - t0
        used["corners"] += t2 - t1
print(
    f"OpenCV {cv2.__version__}, {cv2.getNumThreads()} thread: flow {1e3 * used['flow'] / frames:.3f} ms, corners "
    f"{1e3 * used['corners'] / frames:.3f} ms a frame in the mean, cpu {20 * sum(used.values()) / frames:.4f} s a second at 20 Hz, "
    f"{tracked / frames:.0f} tracks"
)
