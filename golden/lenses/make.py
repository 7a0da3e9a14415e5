"""Writes golden.json: points and the pixels that lenses give them.

Radial-tangential, equidistant and unified pixels are OpenCV's (cv2.projectPoints, cv2.fisheye, cv2.omnidir); enhanced unified, double sphere and field of
view are written out here from Khomutenko et al. 2016 (domain Usenko et al. 2018, eq. 29), Usenko et al. 2018 (eq. 40 to 43, domain eq. 43 to 45) and Devernay and Faugeras
2001, on mpmath's numbers.
null is a point that the lens does not see.

    pip install numpy mpmath opencv-contrib-python-headless && python golden/lenses/make.py
"""

import json
import pathlib

import cv2
import mpmath as mp
import numpy as np

RNG = np.random.default_rng(24)
TUMVI = [0.0034823894022493434, 0.0007150348452162257, -0.0020532361418706202, 0.00020293673591811182]


def points(widest_deg, count=60):
    """Directions up to an angle off the axis, at depths from half a metre to twenty."""
    angle = np.radians(widest_deg) * np.sqrt(RNG.uniform(0, 1, count))
    around = RNG.uniform(-np.pi, np.pi, count)
    ray = np.stack([np.sin(angle) * np.cos(around), np.sin(angle) * np.sin(around), np.cos(angle)], 1)
    ray = ray * RNG.uniform(0.5, 20, (count, 1))
    ray[0] = [0, 0, 2]
    return ray


def matrix(intrinsics):
    fx, fy, cx, cy = intrinsics
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])


def pinhole(p, intrinsics, c):
    px, _ = cv2.projectPoints(p.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), matrix(intrinsics), np.array(c))
    return px.reshape(-1, 2).tolist()


def fisheye(p, intrinsics, c):
    px, _ = cv2.fisheye.projectPoints(p.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), matrix(intrinsics), np.array(c))
    return px.reshape(-1, 2).tolist()


def omni(p, intrinsics, c):
    px, _ = cv2.omnidir.projectPoints(
        p.reshape(-1, 1, 3), np.zeros(3), np.zeros(3), matrix(intrinsics), c[0], np.array(c[1:]))
    return px.reshape(-1, 2).tolist()


def double_sphere(p, intrinsics, c):
    (fx, fy, cx, cy), (xi, alpha) = intrinsics, map(mp.mpf, c)
    w1 = alpha / (1 - alpha) if alpha <= 0.5 else (1 - alpha) / alpha
    w2 = (w1 + xi) / mp.sqrt(2 * w1 * xi + xi**2 + 1)
    out = []
    for x, y, z in p.tolist():
        x, y, z = map(mp.mpf, (x, y, z))
        d1 = mp.sqrt(x**2 + y**2 + z**2)
        d2 = mp.sqrt(x**2 + y**2 + (xi * d1 + z) ** 2)
        under = alpha * d2 + (1 - alpha) * (xi * d1 + z)
        out.append([float(fx * x / under + cx), float(fy * y / under + cy)] if z > -w2 * d1 else None)
    return out


def enhanced_unified(p, intrinsics, c):
    (fx, fy, cx, cy), (alpha, beta) = intrinsics, map(mp.mpf, c)
    w = alpha / (1 - alpha) if alpha <= 0.5 else (1 - alpha) / alpha
    out = []
    for x, y, z in p.tolist():
        x, y, z = map(mp.mpf, (x, y, z))
        d = mp.sqrt(beta * (x**2 + y**2) + z**2)
        under = alpha * d + (1 - alpha) * z
        out.append([float(fx * x / under + cx), float(fy * y / under + cy)] if z > -w * d else None)
    return out


def field_of_view(p, intrinsics, c):
    (fx, fy, cx, cy), w = intrinsics, mp.mpf(c[0])
    out = []
    for x, y, z in p.tolist():
        x, y, z = map(mp.mpf, (x, y, z))
        r = mp.sqrt(x**2 + y**2)
        s = mp.atan2(2 * r * mp.tan(w / 2), z) / (w * r) if r > 0 else 2 * mp.tan(w / 2) / (w * z)
        out.append([float(fx * x * s + cx), float(fy * y * s + cy)])
    return out


EUROC = [458.654, 457.296, 367.215, 248.375]
CASES = [
    ("radtan4", "radial-tangential", [752, 480], EUROC, [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05], 50, pinhole),
    ("radtan5", "radial-tangential", [752, 480], EUROC, [-0.25, 0.06, 1e-3, -2e-3, 0.01], 45, pinhole),
    ("radtan8", "radial-tangential", [1280, 720], [610.0, 611.0, 640.0, 362.0],
     [0.4, -0.3, 3e-4, -2e-4, 0.02, 0.7, -0.25, 0.01], 50, pinhole),
    ("equidistant", "equidistant", [512, 512], [190.978477, 190.973307, 254.931706, 256.897442], TUMVI, 85, fisheye),
    ("equidistant strong", "equidistant", [848, 800], [286.1, 286.3, 425.0, 398.0], [-0.008, 0.042, -0.039, 0.007], 75, fisheye),
    ("omni", "omni", [752, 480], [960.0, 958.0, 370.0, 245.0], [1.2, -0.2, 0.1, 5e-4, -3e-4], 75, omni),
    ("omni under one", "omni", [752, 480], [700.0, 700.0, 370.0, 245.0], [0.7, -0.1, 0.05, 1e-4, -2e-4], 75, omni),
    ("double sphere", "double-sphere", [512, 512], [158.28, 158.29, 254.96, 256.36], [-0.17215, 0.59387], 130, double_sphere),
    ("double sphere, small alpha", "double-sphere", [512, 512], [300.0, 301.0, 254.0, 256.0], [0.2, 0.4], 100, double_sphere),
    ("fov", "fov", [640, 480], [350.0, 352.0, 320.0, 240.0], [0.93], 110, field_of_view),
    ("enhanced unified", "enhanced-unified", [512, 512], [190.9, 191.0, 254.9, 256.9], [0.6283, 1.0458], 130, enhanced_unified),
    ("enhanced unified, small alpha", "enhanced-unified", [752, 480], [460.0, 459.0, 370.0, 245.0], [0.4, 1.3], 100, enhanced_unified),
]
cases = []
for name, model, size, intrinsics, c, widest, project in CASES:
    p = points(widest)
    cases.append(dict(name=name, model=model, resolution=size, intrinsics=intrinsics, coefficients=c,
                      points=p.tolist(), pixels=project(p, intrinsics, c)))
out = dict(made_with=dict(cv2=cv2.__version__, numpy=np.__version__, mpmath=mp.__version__), cases=cases)
pathlib.Path(__file__).with_name("golden.json").write_text(json.dumps(out) + "\n")
