# %% [markdown]
# # How noisy is my IMU, and when?
#
# Every log that `dpn check` reads will do: CSV, rosbag1, MCAP, rosbag2, ULog, ArduPilot, ASL folders. Put yours here. The one below is
# EuRoC's MH_01_easy (ADIS16448 at 200 Hz): on the ground, carried by hand, then flown.

# %%
import os

import matplotlib.pyplot as plt
import numpy as np

import dpn

LOG = os.environ.get("DPN_LOG", "../../data/euroc/MH_01_easy")
log = dpn.read(LOG)
track = dpn.noise(log)  # asks the shipped networks; at a rate that is not theirs a simple estimator

fig, axes = plt.subplots(2, 1, figsize=(9, 5), sharex=True, layout="constrained")
for axis, sigma, name, unit in (
    (axes[0], track.accel, "accelerometer", "m/s²"),
    (axes[1], track.gyro, "gyroscope", "rad/s"),
):
    thin = slice(None, None, max(1, len(track.t) // 700))
    for letter, line in zip("xyz", sigma.T):
        axis.semilogy(track.t[thin], line[thin], lw=0.9, label=letter)
    # Where the signal is unlike all of the training the answer is extrapolated: say so.
    axis.fill_between(
        track.t[thin], 0, 1, where=~track.in_range[thin], transform=axis.get_xaxis_transform(), color="0.88", lw=0, step="post"
    )
    axis.set_ylabel(f"{name}\nσ of a sample [{unit}]")
axes[0].legend(ncols=3, loc="upper left", frameon=False)
axes[0].set_title(f"{os.path.basename(LOG)}, noise by {track.summary['noise']}; grey: outside of the networks' training", fontsize=10)
axes[1].set_xlabel("time [s]")
plt.show()

# %% [markdown]
# One number in a configuration file is one horizontal line through this picture. What the noise is by phase, the median over the
# three axes:

# %%
for phase, name in ((~track.in_range, "outside of the training"), (track.in_range, "inside")):
    if phase.any():
        accel, gyro = np.median(track.accel[phase]), np.median(track.gyro[phase])
        print(f"{name:24} {phase.mean():5.0%} of the log   accelerometer {accel:.4f} m/s²   gyroscope {gyro:.5f} rad/s")

# %% [markdown]
# ## What is wrong with the log?

# %%
for finding in dpn.check(log)["findings"]:
    print(f"{finding['weight']}: {finding['text']}")
