//! The words by which headers call stamps and sensors, in lower case and without what is no letter or digit.

/// A word, its rank among those of its kind, and the unit that it implies (reduced; empty: none).
pub(super) type Word = (&'static str, u8, &'static str);

/// Of stamps.
pub(super) const TIME: [Word; 43] = [
    ("headerstamp", 6, ""),
    ("headerstampsec", 6, "s"),
    ("headerstampsecs", 6, "s"),
    ("timestampsample", 5, ""),
    ("sampletimefine", 5, "fine"),
    ("timestartup", 5, ""),
    ("timeus", 5, "us"),
    ("sensortime", 5, ""),
    ("sensortimestamp", 5, ""),
    ("timestamp", 4, ""),
    ("timestamps", 4, ""),
    ("time", 4, ""),
    ("stamp", 4, ""),
    ("unixtime", 3, ""),
    ("unixtimestamp", 3, ""),
    ("utime", 4, "us"),
    ("ms", 2, "ms"),
    ("us", 2, "us"),
    ("ns", 2, "ns"),
    ("utctimemillis", 3, "ms"),
    // A sensor's own before the rest's.
    ("elapsedrealtimenanos", 6, "ns"),
    ("gyrotimestampsincereboot", 7, "s"),
    ("motiontimestampsincereboot", 6, "s"),
    ("accelerometertimestampsincereboot", 5, "s"),
    // MbientLab writes the time of day beside it.
    ("epoch", 5, ""),
    ("timesincestart", 4, ""),
    ("sincestart", 4, ""),
    ("seconds", 3, "s"),
    ("secondselapsed", 3, "s"),
    ("elapsed", 3, ""),
    ("elapsedtime", 3, ""),
    ("timeelapsed", 3, ""),
    ("millis", 4, "ms"),
    ("micros", 4, "us"),
    ("milliseconds", 4, "ms"),
    ("microseconds", 4, "us"),
    ("nanoseconds", 4, "ns"),
    ("stampsec", 4, "s"),
    ("stampsecs", 4, "s"),
    ("secs", 3, "s"),
    ("sec", 3, "s"),
    ("t", 2, ""),
    ("ts", 2, ""),
];
/// The same in microseconds; they are stamps of their own too.
pub(super) const MICROS: [&str; 10] = [
    "us",
    "usec",
    "usecs",
    "micros",
    "microsec",
    "microseconds",
    "tvusec",
    "timeusec",
    "timestampus",
    "timestampusec",
];
/// Of the rest of a stamp whose whole seconds stand in another column.
pub(super) const NANOS: [&str; 9] = [
    "headerstampnanosec",
    "headerstampnsec",
    "headerstampnsecs",
    "stampnanosec",
    "stampnsec",
    "stampnsecs",
    "nanosec",
    "nsec",
    "nsecs",
];
/// Of gyroscopes, without the axis.
pub(super) const GYRO: [Word; 24] = [
    ("w", 2, ""),
    ("wrss", 3, ""),
    ("g", 2, ""),
    ("gyr", 3, ""),
    ("gy", 3, ""),
    ("gyro", 3, ""),
    ("gyros", 3, ""),
    ("gyrorad", 3, "rads"),
    ("gyroscope", 3, ""),
    ("omega", 3, ""),
    ("angvel", 3, ""),
    ("angularvelocity", 3, ""),
    ("angularrate", 3, ""),
    ("rotationrate", 3, ""),
    ("turnrate", 3, ""),
    // SensorLog, Betaflight and Android's loggers.
    ("motionrotationrate", 3, ""),
    ("gyrorotation", 4, ""),
    ("gyroadc", 2, "degs"),
    ("uncalgyro", 1, ""),
    ("uncompgyro", 1, ""),
    ("uncompangularrate", 1, ""),
    ("gyroscopeuncalibrated", 1, ""),
    ("deltaangle", 1, "rads"),
    ("gyrointegralrad", 1, "rads"),
];
/// Of accelerometers, without the axis.
pub(super) const ACCEL: [Word; 31] = [
    ("a", 2, ""),
    ("arss", 3, ""),
    ("acc", 3, ""),
    ("ac", 3, ""),
    ("accel", 3, ""),
    ("accelerometer", 3, ""),
    ("accelerometerms2", 3, "ms2"),
    ("acceleration", 3, ""),
    ("totalacceleration", 4, ""),
    ("specificforce", 3, ""),
    ("gforce", 4, "g"),
    ("gf", 4, "g"),
    ("f", 2, ""),
    // Kalibr's name, beside its `omega`.
    ("alpha", 1, ""),
    ("linacc", 1, ""),
    ("linaccel", 1, ""),
    ("linearacc", 1, ""),
    ("linearacceleration", 1, ""),
    ("accelerometeracceleration", 4, "g"),
    ("accsmooth", 2, ""),
    ("acce", 3, ""),
    ("uncalaccel", 1, ""),
    ("uncompaccel", 1, ""),
    ("uncompacceleration", 1, ""),
    ("accelerometeruncalibrated", 1, ""),
    ("deltavelocity", 1, "ms2"),
    ("accelerometerintegralms", 1, "ms2"),
    ("useracc", 0, ""),
    ("useraccel", 0, ""),
    ("useracceleration", 0, ""),
    ("motionuseracceleration", 0, ""),
];
/// Of accelerations from which gravity was taken, by Apple's Core Motion or where their numbers say so ([`MAY_LACK_GRAVITY`]), and of that gravity.
pub(super) const WITHOUT_GRAVITY: [(&str, &str); 12] = [
    ("useracceleration", "gravity"),
    ("motionuseracceleration", "motiongravity"),
    ("useracc", "gravity"),
    ("useracc", "grav"),
    ("useraccel", "gravity"),
    ("useraccel", "grav"),
    ("linacc", "gravity"),
    ("linacc", "grav"),
    ("linaccel", "gravity"),
    ("linearacc", "gravity"),
    ("linearacceleration", "gravity"),
    ("linearacceleration", "grav"),
];
/// Of those the ones that robots give to what has gravity in it.
pub(super) const MAY_LACK_GRAVITY: [&str; 4] = ["linacc", "linaccel", "linearacc", "linearacceleration"];
/// Of accelerometers that read -1 g upwards, as Apple's do.
pub(super) const APPLES: [&str; 5] =
    ["accelerometeracceleration", "useracceleration", "motionuseracceleration", "useracc", "useraccel"];
/// Of words for what was gained over an interval, those for the interval.
pub(super) const INTERVALS: [(&str, &str); 4] = [
    ("deltaangle", "deltaangledt"),
    ("gyrointegralrad", "gyrointegraldt"),
    ("deltavelocity", "deltavelocitydt"),
    ("accelerometerintegralms", "accelerometerintegraldt"),
];
