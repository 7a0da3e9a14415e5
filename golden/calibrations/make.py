"""Writes one rig as seven programs write it: what src/io/calibration reads must be the same camera from every file.

Formats, from their public documentation, in our own words and numbers:
  kalibr.yaml          Kalibr's wiki, "Yaml formats" (camchain-imucam.yaml; T_cam_imu, timeshift_cam_imu), imu.yaml
  openvins/            OpenVINS' documentation, "Sensor calibration" (kalibr_imucam_chain.yaml, kalibr_imu_chain.yaml, estimator_config.yaml)
  vins.yaml            VINS-Mono's README and configuration keys; vins_fusion/ as VINS-Fusion splits it
  orbslam3.yaml        ORB-SLAM3's "Calibration_Tutorial.pdf", file format 1.0; orbslam3_old.yaml the keys before it
  basalt.json          Basalt's doc/Calibration.md and basalt-headers' Calibration struct
  okvis2.yaml          OKVIS2's README and configuration keys
  asl.yaml             ASL's dataset format, cam0/sensor.yaml

    python golden/calibrations/make.py
"""

import pathlib

HERE = pathlib.Path(__file__).parent
W, H = 512, 512
FX, FY, CX, CY = 190.97847715128717, 190.9733070521226, 254.93170605935475, 256.8974428996504
K = [0.0034823894022493434, 0.0007150348452162257, -0.0020532361418706202, 0.00020293673591811182]
Q = tuple(v / sum(q * q for q in (0.55, -0.45, 0.5, 0.5)) ** 0.5 for v in (0.55, -0.45, 0.5, 0.5))  # w, x, y, z: camera to IMU
P = (0.0458, -0.0716, -0.0446)
SHIFT = 0.00125  # t_imu = t_cam + SHIFT


def rotation(q):
    w, x, y, z = q
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]


R = rotation(Q)
BC = [R[i] + [P[i]] for i in range(3)] + [[0.0, 0.0, 0.0, 1.0]]  # body from camera
RT = [[R[j][i] for j in range(3)] for i in range(3)]
CB = [RT[i] + [-sum(RT[i][j] * P[j] for j in range(3))] for i in range(3)] + [[0.0, 0.0, 0.0, 1.0]]


def row(values):
    return "[" + ", ".join(repr(float(v)) for v in values) + "]"


def rows(m, indent):
    return "".join(f"{indent}- {row(r)}\n" for r in m)


def flat(m):
    return row(v for r in m for v in r)


def opencv(name, m, cols):
    return (f"{name}: !!opencv-matrix\n   rows: {len(m)}\n   cols: {cols}\n   dt: d\n   data: {flat(m)}\n")


def write(name, text):
    path = HERE / name
    path.parent.mkdir(exist_ok=True)
    path.write_text(text)


DENSITIES = """accelerometer_noise_density: 0.0028
accelerometer_random_walk: 0.00086
gyroscope_noise_density: 0.00016
gyroscope_random_walk: 0.000022
"""
LENS = f"intrinsics: {row([FX, FY, CX, CY])}\n  distortion_model: equidistant\n  distortion_coeffs: {row(K)}\n  resolution: [{W}, {H}]\n"
write("kalibr/camchain-imucam.yaml", f"cam0:\n  T_cam_imu:\n{rows(CB, '  ')}  cam_overlaps: []\n  camera_model: pinhole\n  {LENS}"
      f"  rostopic: /cam0/image_raw\n  timeshift_cam_imu: {SHIFT}\n")
write("kalibr/imu.yaml", DENSITIES + "rostopic: /imu0\nupdate_rate: 200.0\n")
write("kalibr/camchain.yaml", f"cam0:\n  cam_overlaps: []\n  camera_model: pinhole\n  {LENS}  rostopic: /cam0/image_raw\n")
write("openvins/kalibr_imucam_chain.yaml", f"%YAML:1.0\n\ncam0:\n  T_imu_cam:\n{rows(BC, '    ')}  cam_overlaps: []\n"
      f"  camera_model: pinhole\n  {LENS}  rostopic: /cam0/image_raw\n  timeshift_cam_imu: {SHIFT}\n")
write("openvins/kalibr_imu_chain.yaml", "%YAML:1.0\n\nimu0:\n" + "".join(f"  {line}\n" for line in DENSITIES.splitlines())
      + "  T_i_b:\n" + rows([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], "    ") + "  update_rate: 200.0\n")
write("openvins/estimator_config.yaml", '%YAML:1.0\n\nverbosity: "INFO"\nuse_stereo: false\nmax_cameras: 1\n'
      'relative_config_imu: "kalibr_imu_chain.yaml"\nrelative_config_imucam: "kalibr_imucam_chain.yaml"\n')
CAMODOCAL = (f"model_type: KANNALA_BRANDT\ncamera_name: camera\nimage_width: {W}\nimage_height: {H}\nprojection_parameters:\n"
             f"   k2: {K[0]}\n   k3: {K[1]}\n   k4: {K[2]}\n   k5: {K[3]}\n   mu: {FX}\n   mv: {FY}\n   u0: {CX}\n   v0: {CY}\n")
NOISE = "acc_n: 0.08\ngyr_n: 0.004\nacc_w: 0.00004\ngyr_w: 2.0e-6\n"
write("vins.yaml", f'%YAML:1.0\n\nimu_topic: "/imu0"\nimage_topic: "/cam0/image_raw"\n{CAMODOCAL}estimate_extrinsic: 0\n'
      + opencv("extrinsicRotation", R, 3) + opencv("extrinsicTranslation", [[p] for p in P], 1) + NOISE + f"estimate_td: 0\ntd: {SHIFT}\n")
write("vins_fusion/config.yaml", "%YAML:1.0\n\nimu: 1\nnum_of_cam: 1\n" + f'cam0_calib: "cam0.yaml"\nimage_width: {W}\nimage_height: {H}\n'
      + opencv("body_T_cam0", BC, 4) + NOISE + f"td: {SHIFT}\n")
write("vins_fusion/cam0.yaml", "%YAML:1.0\n---\n" + CAMODOCAL)


def orb(prefix, pose):
    intrinsics = "".join(f"{prefix}.{n}: {v}\n" for n, v in zip(("fx", "fy", "cx", "cy"), (FX, FY, CX, CY)))
    lens = "".join(f"{prefix}.k{i + 1}: {v}\n" for i, v in enumerate(K))
    return ('%YAML:1.0\n\nCamera.type: "KannalaBrandt8"\n' + intrinsics + lens + f"Camera.width: {W}\nCamera.height: {H}\nCamera.fps: 20\n"
            + opencv(pose, BC, 4) + "IMU.NoiseGyro: 0.00016\nIMU.NoiseAcc: 0.0028\nIMU.GyroWalk: 0.000022\nIMU.AccWalk: 0.00086\nIMU.Frequency: 200.0\n")


write("orbslam3.yaml", orb("Camera1", "IMU.T_b_c1").replace("%YAML:1.0\n", '%YAML:1.0\n\nFile.version: "1.0"\n', 1))
write("orbslam3_old.yaml", orb("Camera", "Tbc"))
w, x, y, z = Q
write("basalt.json", f"""{{
    "value0": {{
        "T_imu_cam": [
            {{ "px": {P[0]}, "py": {P[1]}, "pz": {P[2]}, "qx": {x}, "qy": {y}, "qz": {z}, "qw": {w} }}
        ],
        "intrinsics": [
            {{
                "camera_type": "kb4",
                "intrinsics": {{ "fx": {FX}, "fy": {FY}, "cx": {CX}, "cy": {CY}, "k1": {K[0]}, "k2": {K[1]}, "k3": {K[2]}, "k4": {K[3]} }}
            }}
        ],
        "resolution": [[{W}, {H}]],
        "imu_update_rate": 200.0,
        "accel_noise_std": [0.0028, 0.0028, 0.0028],
        "gyro_noise_std": [0.00016, 0.00016, 0.00016],
        "accel_bias_std": [0.00086, 0.00086, 0.00086],
        "gyro_bias_std": [0.000022, 0.000022, 0.000022],
        "cam_time_offset_ns": {round(SHIFT * 1e9)}
    }}
}}
""")
write("okvis2.yaml", f"""%YAML:1.0
cameras:
     - {{T_SC: {flat(BC)},
        image_dimension: [{W}, {H}],
        distortion_coefficients: {row(K)},
        distortion_type: equidistant,
        focal_length: [{FX}, {FY}],
        principal_point: [{CX}, {CY}],
        camera_type: gray,
        slam_use: okvis}}
camera_parameters:
    timestamp_tolerance: 0.005
    image_delay: {-SHIFT}
imu_parameters:
    use: true
    sigma_g_c: 0.00016
    sigma_a_c: 0.0028
    sigma_gw_c: 0.000022
    sigma_aw_c: 0.00086
""")
write("asl.yaml", f"""sensor_type: camera
T_BS:
  cols: 4
  rows: 4
  data: {flat(BC)}
rate_hz: 20
resolution: [{W}, {H}]
camera_model: pinhole
intrinsics: {row([FX, FY, CX, CY])}
distortion_model: equidistant
distortion_coefficients: {row(K)}
""")
