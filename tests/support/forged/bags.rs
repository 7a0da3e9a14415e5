//! Bags whose heads promise more than they hold, or hold more than they say.

use super::Forged;

/// Forty million zeros, as bz2 packs them.
const ZEROS: [u8; 51] = [
    0x42, 0x5a, 0x68, 0x39, 0x31, 0x41, 0x59, 0x26, 0x53, 0x59, 0xd8, 0xec, 0xdd, 0xfe, 0x01, 0x32, 0x5f,
    0x40, 0x08, 0xc0, 0x00, 0x00, 0x10, 0x00, 0x08, 0x20, 0x00, 0x30, 0xcc, 0x09, 0xaa, 0x69, 0xa0, 0x4a,
    0x51, 0x5b, 0x50, 0x12, 0x94, 0x57, 0x8b, 0xb9, 0x22, 0x9c, 0x28, 0x48, 0x6c, 0x76, 0x6e, 0xff, 0x00,
];

/// A record of an MCAP file.
fn record(op: u8, content: &[u8]) -> Vec<u8> {
    [&[op][..], &(content.len() as u64).to_le_bytes(), content].concat()
}

fn counted(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

fn mcap(records: &[Vec<u8>]) -> Vec<u8> {
    [b"\x89MCAP0\r\n".to_vec(), records.concat()].concat()
}

/// A chunk that says it unpacks to a gigabyte.
fn chunk(compression: &str, packed: &[u8]) -> Vec<u8> {
    let head = [vec![0; 16], (1u64 << 30).to_le_bytes().to_vec(), vec![0; 4], counted(compression)].concat();
    record(6, &[head, (packed.len() as u64).to_le_bytes().to_vec(), packed.to_vec()].concat())
}

fn rosbag1(records: &[Vec<u8>]) -> Vec<u8> {
    [b"#ROSBAG V2.0\n".to_vec(), records.concat()].concat()
}

/// A rosbag1's chunk that says it unpacks to a gigabyte.
fn rosbag1_chunk(compression: &[u8], packed: &[u8]) -> Vec<u8> {
    let sized = |bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes()[..], bytes].concat();
    let field = |name: &str, value: &[u8]| sized(&[name.as_bytes(), b"=", value].concat());
    let size = (1u32 << 30).to_le_bytes();
    let head = [field("op", &[5]), field("compression", compression), field("size", &size)].concat();
    [sized(&head), sized(packed)].concat()
}

/// An MCAP of 150,000 channels, one of them an IMU's.
pub fn many_channels() -> Vec<u8> {
    let imu = record(
        3,
        &[1u16.to_le_bytes().to_vec(), counted("sensor_msgs/msg/Imu"), counted(""), counted("")].concat(),
    );
    let channels = (0..150_000u32).map(|i| {
        let number = (i as u16).to_le_bytes().to_vec();
        let topic = counted(&format!("/{i}"));
        record(4, &[number, 1u16.to_le_bytes().to_vec(), topic, counted("cdr"), vec![0; 4]].concat())
    });
    mcap(&[vec![imu], channels.collect()].concat())
}

/// A ULog of formats that hold one another, and subscriptions of topics that nobody knows.
fn many_formats() -> Vec<u8> {
    let message =
        |kind: u8, text: &str| [&(text.len() as u16).to_le_bytes()[..], &[kind], text.as_bytes()].concat();
    let formats = (0..100_000).map(|i| message(b'F', &format!("f{i}:f{} a;f{} b;", i + 1, i + 2)));
    let imu = message(
        b'F',
        "sensor_combined:f0 a;float[3] gyro_rad;float[3] accelerometer_m_s2;uint64_t timestamp;",
    );
    let subscribed = (0..50_000).map(|_| message(b'A', "\0\x01\0sensor_combined"));
    [
        [&b"ULog\x01\x12\x35\x01"[..], &[0; 8]].concat(),
        formats.collect::<Vec<_>>().concat(),
        imu,
        subscribed.collect::<Vec<_>>().concat(),
    ]
    .concat()
}

/// A gzip stream of zeros, 2 kB to 13 bytes: a block of fixed codes that copies the byte before 258 times over, again and again.
fn gzip_zeros(times: usize) -> Vec<u8> {
    // Codes come with their first bit first: a last block of fixed codes, a zero, `times` times eight copies (length 258, distance 1), the end.
    let copy = "1100010100000";
    let bits = ["1", "10", "00110000", &copy.repeat(8 * times), "0000000"].concat();
    let bytes = bits
        .as_bytes()
        .chunks(8)
        .map(|bits| bits.iter().enumerate().fold(0, |byte, (at, bit)| byte | u8::from(*bit == b'1') << at));
    [b"\x1f\x8b\x08\0\0\0\0\0\0\x03".to_vec(), bytes.collect()].concat()
}

/// ArduPilot's binary log that describes and describes records: each FMT names a length, a name and units of columns.
fn many_records() -> Vec<u8> {
    let format = |kind: u8, name: String| {
        let mut record = vec![0xa3, 0x95, 0x80, kind, 89];
        record.extend(name.bytes().chain([0; 4]).take(4));
        record.extend(b"QffffffQQQQQQQQQ");
        record.extend(b"TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,I,".iter().copied().chain([0; 64]).take(64));
        record
    };
    (0..60_000_u32).flat_map(|i| format(i as u8, format!("{:03x}", i % 4096))).collect()
}

/// All of them, with the ending of each one's name.
pub fn bags() -> Vec<(Forged, &'static str)> {
    let mut all = Vec::new();
    let mut bag = |name: &str, ending, make: fn() -> Vec<u8>| all.push((Forged::new(name, make), ending));
    bag("a bz2 bag of a gigabyte", "bag", || rosbag1(&[rosbag1_chunk(b"bz2", &ZEROS.repeat(25))]));
    bag("a bz2 bag of twenty gigabytes", "bag", || {
        rosbag1(&vec![rosbag1_chunk(b"bz2", &ZEROS.repeat(25)); 20])
    });
    bag("an lz4 bag that says a gigabyte", "bag", || {
        rosbag1(&vec![rosbag1_chunk(b"lz4", b"\x04\x22\x4d\x18"); 20_000])
    });
    bag("a header of four gigabytes", "bag", || rosbag1(&[vec![0xff; 100]]));
    bag("a bag of zeros", "bag", || rosbag1(&[vec![0; 8 << 20]]));
    bag("an MCAP record of many gigabytes", "mcap", || mcap(&[[&[6][..], &[0xff; 7], &[0]].concat()]));
    bag("an MCAP of zeros", "mcap", || mcap(&[vec![0; 8 << 20]]));
    bag("an MCAP of a zstd bomb", "mcap", || {
        // A window of 64 MB, then blocks that each repeat a byte 128,000 times.
        let blocks = [0x02u8, 0x00, 0x10, 0x00].repeat(8000);
        mcap(&[chunk("zstd", &[b"\x28\xb5\x2f\xfd\x00\x80".to_vec(), blocks].concat())])
    });
    bag("an MCAP of a bz2 bomb", "mcap", || mcap(&[chunk("bz2", &ZEROS.repeat(25))]));
    bag("chunks that say a gigabyte and hold nothing", "mcap", || {
        mcap(&vec![chunk("lz4", b"\x04\x22\x4d\x18"); 20_000])
    });
    bag("an MCAP of 150,000 channels", "mcap", many_channels);
    // Packed as a whole.
    bag("a bz2 log of a gigabyte", "csv.bz2", || ZEROS.repeat(25));
    bag("a gzip log of a gigabyte", "csv.gz", || gzip_zeros(1 << 19));
    bag("a zstd log of a window of 64 MB", "csv.zst", || {
        [b"\x28\xb5\x2f\xfd\x00\x80".to_vec(), [0x02u8, 0x00, 0x10, 0x00].repeat(8000)].concat()
    });
    // A stream's head, then a block's that says so.
    bag("an xz log of a dictionary of four gigabytes", "csv.xz", || {
        b"\xfd7zXZ\0\0\x04\xe6\xd6\xb4\x46\x02\0\x21\x01\x28\0\0\0\xe6\xa0\x11\xb3".to_vec()
    });
    // Its index says that fifteen thousand million records follow.
    bag("an xz log of an index without an end", "csv.xz", || {
        b"\xfd7zXZ\0\0\x04\xe6\xd6\xb4\x46\0\xff\xff\xff\xff\x38\0\0\0".to_vec()
    });
    bag("a ULog of zeros", "ulg", || [b"ULog\x01\x12\x35\x01".to_vec(), vec![0; 4 << 20]].concat());
    bag("a ULog of 100,000 formats", "ulg", many_formats);
    bag("an ArduPilot log of zeros", "bin", || [vec![0xa3, 0x95, 0x80], vec![0; 4 << 20]].concat());
    bag("an ArduPilot log of 60,000 formats", "bin", many_records);
    bag("an ArduPilot log of a line without an end", "log", || {
        [b"FMT, ".to_vec(), vec![b'7'; 8 << 20]].concat()
    });
    bag("a database of zeros", "db3", || [b"SQLite format 3\0".to_vec(), vec![0; 4 << 20]].concat());
    bag("a database's head alone", "db3", || b"SQLite format 3\0".to_vec());
    all
}
