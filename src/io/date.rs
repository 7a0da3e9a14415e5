//! Dates and times of day as stamps: `2023-10-29T02:59:40.25+01:00` and its kin (ISO 8601; a blank or a slash for the T, slashes in the date), of UTC where no zone
//! stands beside it; `02:59:40.25` alone counts from midnight.

use super::TimeUnit;
use super::decimal::parse_stamp;
use dpn_core::Stamp;
use time::{Date, Month, Time, UtcDateTime};

/// Reads one; `None` where it is none.
pub(crate) fn parse(text: &[u8]) -> Option<Stamp> {
    let text = std::str::from_utf8(text).ok().filter(|text| text.len() <= 40)?;
    let colon = text.find(':')?;
    // The time of day begins two digits before its first colon.
    let (date, time) = text.split_at_checked(colon.checked_sub(2)?)?;
    let days = if date.is_empty() { 0 } else { day(date)? };
    let zone = time.find(['Z', 'z', '+', '-', ' ']).unwrap_or(time.len());
    let (time, zone) = time.split_at(zone);
    let mut parts = time.splitn(3, ':');
    let [hour, minute] = [parts.next()?, parts.next()?].map(|part| number(part, 2));
    let seconds = parts.next()?;
    let is_plain =
        seconds.bytes().enumerate().all(|(i, b)| if i == 2 { b == b'.' } else { b.is_ascii_digit() });
    let seconds = Some(seconds).filter(|text| is_plain && text.len() >= 2)?;
    let (hour, minute) = (hour?, minute?);
    Time::from_hms(hour.try_into().ok()?, minute.try_into().ok()?, seconds[..2].parse().ok()?).ok()?;
    let seconds = parse_stamp(seconds.as_bytes(), TimeUnit::Seconds)?.ns();
    let minutes = days.checked_mul(1440)? + 60 * hour + minute - offset(zone.trim())?;
    minutes.checked_mul(60_000_000_000)?.checked_add(seconds).map(Stamp::from_ns)
}

/// A whole number of so many digits.
fn number(text: &str, digits: usize) -> Option<i64> {
    (text.len() == digits && text.bytes().all(|b| b.is_ascii_digit())).then(|| text.parse().ok())?
}

/// Days since 1970 of a date before a time of day, year first.
fn day(text: &str) -> Option<i64> {
    let text = text.strip_suffix(['T', 't', ' ', '_', '/', '-'])?.trim_end();
    let mut parts = text.split(['-', '/']);
    let [year, month, day] = [4, 2, 2].map(|digits| parts.next().and_then(|part| number(part, digits)));
    let month = Month::try_from(u8::try_from(month?).ok()?).ok()?;
    let date = Date::from_calendar_date(year?.try_into().ok()?, month, day?.try_into().ok()?).ok()?;
    parts
        .next()
        .is_none()
        .then(|| i64::from(date.to_julian_day() - UtcDateTime::UNIX_EPOCH.date().to_julian_day()))
}

/// Minutes east of Greenwich.
fn offset(zone: &str) -> Option<i64> {
    let sign = match zone {
        "" | "Z" | "z" | "UTC" => return Some(0),
        _ if zone.starts_with('-') => -1,
        _ if zone.starts_with('+') => 1,
        _ => return None,
    };
    let digits: String = zone[1..].chars().filter(|c| *c != ':').collect();
    let (hours, minutes) = digits.split_at_checked(2)?;
    let minutes = if minutes.is_empty() { 0 } else { number(minutes, 2)? };
    Some(sign * (60 * number(hours, 2)? + minutes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ns(text: &str) -> Option<i64> {
        parse(text.as_bytes()).map(Stamp::ns)
    }

    #[test]
    fn dates_of_every_spelling_are_one_instant() {
        let t = 1_698_544_780_250_000_000;
        for text in [
            "2023-10-29T01:59:40.25Z",
            "2023-10-29T02:59:40.250000+01:00",
            "2023-10-28 20:59:40.25-0500",
            "2023/10/29 01:59:40.250000000",
            "2023/10/29/01:59:40.25",
            "2023-10-29 01:59:40.25 UTC",
            "2023-10-29T07:29:40.25 +05:30",
        ] {
            assert_eq!(ns(text), Some(t), "{text}");
        }
        assert_eq!(ns("1970-01-01T00:00:00Z"), Some(0));
        assert_eq!(ns("2000-02-29T00:00:00.000000001"), Some(951_782_400_000_000_001));
        assert_eq!(ns("00:01:02.5"), Some(62_500_000_000));
        // Whose day and month could be either is asked about.
        for text in [
            "29.10.2023 01:59:40",
            "10/29/2023 01:59:40",
            "2023-13-01T00:00:00",
            "2023-02-29T00:00:00",
            "2023-02-28T24:00:00",
            "1:2:3",
            "01:02",
            "12:00:00+",
            "a:b:c",
            "2023-10-29T01:59:40.2.5",
        ] {
            assert_eq!(ns(text), None, "{text}");
        }
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "[0-9TZ:+./ é-]{0,30}") {
            let _ = parse(text.as_bytes());
        }
    }
}
