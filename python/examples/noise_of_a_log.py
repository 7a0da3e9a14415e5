# %% [markdown]
# # How noisy is my IMU, and when?
#
# Put your log's path below: CSV, rosbag1, MCAP, rosbag2, ULog, ArduPilot, an ASL folder. This one is EuRoC's MH_01_easy (ADIS16448 at
# 200 Hz): on the ground, carried by hand, motors on, flown.

# %%
import os

import matplotlib.pyplot as plt

import dpn

LOG = os.environ.get("DPN_LOG", "../../data/euroc/MH_01_easy")
log = dpn.read(LOG)
track = dpn.noise(log)  # asks the shipped networks; at a rate that is not theirs a simple estimator
simple = dpn.noise(log, "diff2")  # no network: second differences, which take vibration for noise
constant = dpn.noise(log, "x1")  # what a configuration file says: VINS-Mono's

fig, axes = plt.subplots(2, 1, figsize=(9, 5), sharex=True, layout="constrained")
thin = slice(None, None, max(1, len(track.t) // 500))
for axis, name, sigma, plain, told in (
    (axes[0], "accelerometer [m/s²]", track.accel, simple.accel, constant.accel[0, 0]),
    (axes[1], "gyroscope [rad/s]", track.gyro, simple.gyro, constant.gyro[0, 0]),
):
    axis.semilogy(simple.t[thin], plain[thin].max(axis=1), lw=0.8, color="0.55", label="second differences")
    for letter, line in zip("xyz", sigma.T):
        axis.semilogy(track.t[thin], line[thin], lw=0.9, label=letter)
    axis.axhline(told, color="black", lw=0.9, ls="--", label="constant of VINS-Mono")
    # Where the signal is unlike all of the training the answer is extrapolated.
    outside = ~track.in_range[thin]
    axis.fill_between(
        track.t[thin], 0, 1, where=outside, transform=axis.get_xaxis_transform(), color="0.9", lw=0, label="outside of the training"
    )
    axis.set_ylabel(name)
axes[1].legend(ncols=3, loc="lower right", fontsize=8)
axes[0].set_title(f"{os.path.basename(LOG)}: standard deviation of a sample, by {track.model}", fontsize=10)
axes[1].set_xlabel("time [s]")
plt.show()

# %% [markdown]
# One number in a configuration file is one horizontal line through this picture. In the grey the networks stay at the end of the range they
# were trained for, and second differences take the rotors for noise: what to tell an estimator there is the last cell. By phase, the median
# over time:

# %%
print(f"{'phase':12} {'seconds':>8}   accelerometer x y z [m/s²]    gyroscope x y z [rad/s]      outside")
for phase in track.summary["summary"]["phases"]:
    middle = [axis["sigma"]["middle"] for axis in phase["axes"]]
    # None in a phase shorter than a window, nor of a simple estimator.
    shares = [part["share"] for part in phase["outside"]]
    accel, gyro = (" ".join(f"{value:8.4f}" for value in part) for part in (middle[:3], middle[3:]))
    outside = f"{max(shares):7.0%}" if shares else "      -"
    print(f"{phase['phase'] or 'all':12} {phase['seconds']:8.1f}   {accel}    {gyro}   {outside}")

# %% [markdown]
# ## What is wrong with the log?

# %%
for finding in dpn.check(log).findings[:6]:
    print(f"{finding.weight}: {finding.text}")

# %% [markdown]
# ## What to paste into a configuration
#
# The white noise that errs as much over a tenth of a second as this log's does, vibration included, in Kalibr's words. `dpn.convert`
# writes any of the others.

# %%
effective = track.summary["effective"]
print(effective["pasted"][0]["text"] if effective and effective["pasted"] else "nothing to paste: see dpn.allan(log, all=True)")
