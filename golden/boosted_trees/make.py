# requirements: numpy, scipy, scikit-learn >= 1.7 (versions used stand in the file it writes)
"""Writes result.json: histogram-boosted trees on the window features of train/features.rs, judged like the networks.

The windows (200 samples of one axis, disjoint), the split, the bases, the levels and the labels are those of
`dpn eval --open-loop`; the noise is numpy's, so rows differ from dpn's by chance alone. Trees are grown on the first 85 % of
EuRoC's training sequences, less a window's gap, until the last 15 % have not improved for 30 trees. For raw TUM-VI they are
grown on EuRoC as `configs/train/*-raw.toml` says (Gaussian bases, grown and shrunk, continuous levels) and on SG(51,3); of
these two the better one on rooms 1 and 2 is the row. Test sequences choose nothing.

Besides, `features` holds a window and its features: a test of train/features.rs keeps both computations the same.

Run in this folder: python3 make.py DATA    (the folder that holds euroc/ and tumvi/; under a minute of CPU)
"""
import functools
import json
import pathlib
import sys

import numpy as np
import scipy
import sklearn
from scipy.signal import savgol_filter
from sklearn.ensemble import HistGradientBoostingRegressor

WINDOW, DRAWS, SEED = 200, 2, 0
STUDY = [(5, 2), (7, 2), (11, 2), (21, 3), (51, 3)]
TRAIN = ["MH_01", "MH_03", "MH_05", "V1_02", "V2_01", "V2_03"]
TEST = ["MH_02", "MH_04", "V1_01", "V1_03", "V2_02"]
LEVELS = {"accel": (0.01, 0.21, 11), "gyro": (0.001, 0.015, 8)}
RAW_LEVELS = {"accel": (0.005, 0.23), "gyro": (0.00035, 0.0161)}  # configs/train/*-raw.toml
GAUSSIAN_WIDTHS = [1.5, 2.0, 3.0, 4.5]  # train/clean.rs
MAD_TO_SIGMA = 1.482602218505602
DB4 = np.array(
    [
        0.2303778133088965, 0.7148465705529157, 0.6308807679298589, -0.02798376941685985,
        -0.1870348117190931, 0.03084138183556076, 0.0328830116668852, -0.01059740178506903,
    ]
)


# Features, as train/features.rs

def projection(window, order):
    """The matrix of one Savitzky-Golay filter over a whole window, polynomial edges included."""
    return savgol_filter(np.eye(WINDOW), window, order, axis=0, mode="interp")


SMOOTH = {base: projection(*base) for base in STUDY}


def residual_rms(x, base):
    """Deviation of white noise that would leave the same residual."""
    gain = np.sqrt(np.mean(1 - np.diag(SMOOTH[base])))
    return np.sqrt(np.mean((x - x @ SMOOTH[base].T) ** 2, axis=1)) / gain


def mad(x):
    return MAD_TO_SIGMA * np.median(np.abs(x - np.median(x, axis=1, keepdims=True)), axis=1)


def band_power(x, bands=10, rate=200.0):
    hann = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(WINDOW) / WINDOW)
    density = np.abs(np.fft.rfft((x - x.mean(1, keepdims=True)) * hann, axis=1)) ** 2 / (rate * np.sum(hann**2))
    density[:, 1:-1] *= 2
    bin_hz, nyquist = rate / WINDOW, rate / 2
    k = np.arange(density.shape[1])
    low, high = np.maximum((k - 0.5) * bin_hz, 0), np.minimum((k + 0.5) * bin_hz, nyquist)
    edges = np.linspace(0, nyquist, bands + 1)
    share = np.clip(np.minimum(high[:, None], edges[1:]) - np.maximum(low[:, None], edges[:-1]), 0, None)
    return density @ (bin_hz * share / (high - low)[:, None])


def features(x):
    """x: [rows, 200] -> [rows, 21]."""
    columns = [residual_rms(x, base) for base in STUDY]
    for order in range(1, 5):
        gain = np.sqrt(scipy.special.comb(2 * order, order))
        columns.append(np.diff(x, order, axis=1).std(axis=1, ddof=1) / gain)
    columns.append(mad(np.diff(x, 2, axis=1)) / np.sqrt(6))
    high = DB4 * np.where(np.arange(8) % 2 == 0, -1, 1)
    views = np.lib.stride_tricks.sliding_window_view(x, 8, axis=1)[:, ::2]
    columns.append(mad(views @ high[::-1]))
    columns.extend(np.sqrt(np.maximum(band_power(x), 0)).T)
    return np.log(np.maximum(np.column_stack(columns), 1e-9))


# Windows, as train/windows.rs and train/examples.rs

@functools.cache
def table_of(data, name):
    (path,) = (p for pack in ("euroc", "tumvi") for p in pathlib.Path(data, pack).glob(f"*{name}*/mav0/imu0/data.csv"))
    return np.loadtxt(path, delimiter=",", comments="#")


def recordings(data, names, sensor):
    for table in (table_of(data, name) for name in names):
        columns = slice(4, 7) if sensor == "accel" else slice(1, 4)
        yield table[:, 0].astype(np.int64), table[:, columns]


def cut(data, names, sensor, stretch="whole", rng=None):
    """[windows, 200]; no window crosses a gap. With `rng`, each run's first window starts up to a window late."""
    out = []
    for stamps, samples in recordings(data, names, sensor):
        split = round(0.85 * len(samples))
        first, end = {"whole": (0, len(samples)), "fit": (0, split - WINDOW), "validation": (split, len(samples))}[stretch]
        stamps, samples = stamps[first:end], samples[first:end]
        gaps = np.flatnonzero(np.diff(stamps) > 1.5 * np.median(np.diff(stamps))) + 1
        runs = np.split(samples, gaps)
        for run in runs:
            run = run[rng.integers(WINDOW) if rng else 0 :]
            out += [run[: len(run) // WINDOW * WINDOW, axis].reshape(-1, WINDOW) for axis in range(3)]
    return np.concatenate(out)


def clean(windows, base):
    if base == "raw":
        return windows
    if base != "gaussian":
        return windows @ SMOOTH[base].T
    out = np.empty_like(windows)
    for which, width in enumerate(GAUSSIAN_WIDTHS):
        reach = int(np.ceil(6 * width))
        kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / width) ** 2)
        mine = windows[which :: len(GAUSSIAN_WIDTHS)]
        turned = np.pad(mine, ((0, 0), (reach, reach)), mode="reflect", reflect_type="odd")
        out[which :: len(GAUSSIAN_WIDTHS)] = np.apply_along_axis(np.convolve, 1, turned, kernel / kernel.sum(), "valid")
    return out


def examples(base_windows, sensor, kind, rng):
    """Every window at every level: noisy windows, injected deviation, own deviation."""
    low, high, steps = LEVELS[sensor]
    rows = np.repeat(base_windows, steps, axis=0)
    if kind == "grid":
        sigma = np.tile(np.linspace(low, high, steps), len(base_windows))
    else:
        sigma = low + (high - low) * (np.tile(np.arange(steps), len(base_windows)) + rng.random(len(rows))) / steps
    own = np.repeat(residual_rms(base_windows, (5, 2)), steps)
    return rows + sigma[:, None] * rng.standard_normal(rows.shape), sigma, own


def raw_examples(base_windows, sensor, rng):
    """Windows grown or shrunk about their means, continuous levels of the wider range."""
    rows = np.repeat(base_windows, LEVELS[sensor][2], axis=0)
    factor = 0.2 * 10 ** rng.random((len(rows), 1))
    mean = rows.mean(1, keepdims=True)
    sigma = rng.uniform(*RAW_LEVELS[sensor], len(rows))
    return mean + factor * (rows - mean) + sigma[:, None] * rng.standard_normal(rows.shape), sigma


def grow(data, sensor, base, noisy, rng):
    """Trees on DRAWS noisy and shifted copies of the fit windows, stopped on the validation windows."""
    fit = [noisy(clean(cut(data, TRAIN, sensor, "fit", rng), base)) for _ in range(DRAWS)]
    held_out = noisy(clean(cut(data, TRAIN, sensor, "validation"), base))
    scale = held_out[1].max()  # trees stop on absolute improvement: about one is where they are at home
    trees = HistGradientBoostingRegressor(
        learning_rate=0.05, max_iter=1000, min_samples_leaf=50, early_stopping=True, n_iter_no_change=30, random_state=SEED
    )
    table = np.concatenate([features(x) for x, _ in fit])
    trees.fit(
        table,
        np.concatenate([sigma for _, sigma in fit]) / scale,
        X_val=features(held_out[0]),
        y_val=held_out[1] / scale,
    )
    return lambda x: scale * trees.predict(features(x)), int(trees.n_iter_)


def rmse(a, b):
    return float(np.sqrt(np.mean((a - b) ** 2)))


def euroc_row(data, sensor, base, kind):
    rng = np.random.default_rng(SEED)
    predict, count = grow(data, sensor, base, lambda windows: examples(windows, sensor, kind, rng)[:2], rng)
    row = {"sensor": sensor, "base": f"sg({base[0]},{base[1]})", "levels": kind, "label": "sigma_inj", "trees": count}
    for side, names in (("train", TRAIN), ("test", TEST)):
        x, sigma, _ = examples(clean(cut(data, names, sensor), base), sensor, kind, rng)
        row[f"rmse_{side}"], row[f"n_{side}"] = rmse(predict(x), sigma), len(sigma)
    return row, predict


def tumvi_row(data, sensor, on_sg51):
    rng = np.random.default_rng(SEED)
    on_gaussian, _ = grow(data, sensor, "gaussian", lambda windows: raw_examples(windows, sensor, rng), rng)

    def judge(predict, names):
        x, sigma, own = examples(cut(data, names, sensor), sensor, "grid", np.random.default_rng(SEED + 1))
        return rmse(predict(x), np.hypot(sigma, own)), len(sigma)

    recipes = {"gaussian": on_gaussian, "sg(51,3)": on_sg51}
    rooms12 = {name: judge(predict, ["room1", "room2"])[0] for name, predict in recipes.items()}
    best = min(rooms12, key=rooms12.get)
    value, n = judge(recipes[best], ["room3", "room4"])
    return {
        "sensor": sensor, "base": "raw", "levels": "grid", "label": "sigma_tot", "data": "tumvi",
        "grown_on": best, "rmse_rooms_1_2": rooms12, "rmse_test": value, "n_test": n,
    }  # fmt: skip


def main(data):
    rows = []
    for sensor in LEVELS:
        for base, kind in [((51, 3), "continuous"), ((11, 2), "grid"), ((7, 2), "grid"), ((5, 2), "grid")]:
            row, predict = euroc_row(data, sensor, base, kind)
            rows.append(row)
            if base == (51, 3):
                on_sg51 = predict
            print(row, flush=True)
        rows.append(tumvi_row(data, sensor, on_sg51))
        print(rows[-1], flush=True)
    window = 9.81 + 0.3 * np.sin(0.7 * np.arange(WINDOW)) + 0.05 * np.random.default_rng(7).standard_normal(WINDOW)
    result = {
        "versions": {
            "python": sys.version.split()[0], "numpy": np.__version__, "scipy": scipy.__version__, "sklearn": sklearn.__version__,
        },
        "draws": DRAWS,
        "seed": SEED,
        "rows": rows,
        "features": {"window": window.tolist(), "values": features(window[None])[0].tolist()},
    }  # fmt: skip
    with open("result.json", "w") as file:
        json.dump(result, file, indent=1)
        file.write("\n")


if __name__ == "__main__":
    main(sys.argv[1])
