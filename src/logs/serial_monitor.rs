//! A board's lines as the monitor of Arduino's IDE shows them with their times: `12:34:56.789 -> 0.01,0.02,9.81`.

use crate::json::is_number;

/// What stands between the time of day and the line.
const ARROW: &str = " ->";
/// Lines that are looked at.
const LINES: usize = 50;

/// The time of a line, and the line.
fn parts(line: &str) -> Option<(&str, &str)> {
    let (time, line) = line.split_once(ARROW)?;
    let is_time = |byte: u8| byte.is_ascii_digit() || b":.".contains(&byte);
    let time = time.trim();
    (time.matches(':').count() == 2 && time.bytes().all(is_time)).then(|| (time, line.trim()))
}

/// Whether a file's lines are such; one may be cut off or damaged.
pub(crate) fn is(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head);
    let lines = || text.lines().take(LINES);
    lines().next().is_some_and(|line| parts(line).is_some())
        && lines().filter(|line| parts(line).is_none()).count() <= 1
}

/// The lines with their time as a first field; over names it is called `t`, so that a stamp of the board's own goes before it.
pub(crate) fn table(text: &str) -> String {
    let mut table = String::with_capacity(text.len());
    for whole in text.lines() {
        match parts(whole) {
            Some((_, "")) => continue,
            Some((time, line)) => {
                let between = line.chars().find(|c| ",;\t".contains(*c)).unwrap_or(' ');
                let is_names = !line.split([',', ';', '\t', ' ']).any(is_number);
                table.push_str(if is_names { "t" } else { time });
                table.push(between);
                table.push_str(line);
            }
            // What is no such line is the table's reader's to refuse.
            None => table.push_str(whole),
        }
        table.push('\n');
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_becomes_a_field_like_the_boards_own() {
        let text = "12:34:56.789 -> ax,ay,az,gx,gy,gz\n12:34:56.799 -> 1,2,3,4,5,6\n12:34:56.8";
        assert!(is(text.as_bytes()) && !is(b"12:34:56.789,1,2\n") && !is(b"a -> b\n"));
        assert_eq!(table(text), "t,ax,ay,az,gx,gy,gz\n12:34:56.799,1,2,3,4,5,6\n12:34:56.8\n");
        assert_eq!(table("1:02:03.4 -> 1\t2\n1:02:03.5 -> \n"), "1:02:03.4\t1\t2\n");
    }
}
