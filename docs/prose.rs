//! What every page of the book and the README keep to: tables of at most six columns, numbers that begin with a digit, links that
//! lead somewhere, and no page that the contents leave out.

use crate::{at, read};
use std::collections::BTreeSet;

const BOOK: &str = "docs/src";

/// The book's pages and the README, by path from the repository's root.
pub(crate) fn pages() -> Vec<String> {
    let names =
        std::fs::read_dir(at(BOOK)).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut pages: Vec<String> = names.map(|name| format!("{BOOK}/{name}")).collect();
    pages.push("README.md".to_owned());
    pages.sort();
    pages
}

/// Lines with their numbers, without blocks of code.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut in_code = false;
    text.lines().enumerate().filter_map(move |(i, line)| {
        let fence = line.starts_with("```");
        in_code ^= fence;
        (!in_code && !fence).then_some((i + 1, line))
    })
}

/// The line without what stands between backticks.
fn without_code(line: &str) -> String {
    line.split('`').step_by(2).collect::<Vec<_>>().join(" ")
}

/// Where the Markdown links of a line lead.
fn links(line: &str) -> impl Iterator<Item = &str> {
    line.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(link, _)| link)
}

/// The anchor that a heading gets: lower case, words joined by hyphens, nothing else kept.
fn anchor(heading: &str) -> String {
    let kept = heading.trim_start_matches('#').trim().to_lowercase().replace(' ', "-");
    kept.chars().filter(|c| c.is_alphanumeric() || *c == '-').collect()
}

#[test]
fn tables_have_at_most_six_columns() {
    for page in pages() {
        for (line, text) in read(&page).lines().enumerate().filter(|(_, text)| text.starts_with('|')) {
            let columns = text.replace("\\|", "").matches('|').count() - 1;
            assert!(columns <= 6, "{page}:{}: a table of {columns} columns", line + 1);
        }
    }
}

#[test]
fn numbers_begin_with_a_digit() {
    for page in pages() {
        for (line, text) in lines(&read(&page)) {
            let chars: Vec<char> = format!(" {} ", without_code(text)).chars().collect();
            let bare = chars
                .windows(3)
                .any(|w| !w[0].is_alphanumeric() && w[0] != '.' && w[1] == '.' && w[2].is_ascii_digit());
            assert!(!bare, "{page}:{line}: a number without its leading zero: {text}");
        }
    }
}

#[test]
fn links_lead_somewhere() {
    for page in pages() {
        let folder = page.rsplit_once('/').map_or("", |(folder, _)| folder);
        let text = read(&page);
        for (line, link) in lines(&text).flat_map(|(line, text)| links(text).map(move |link| (line, link))) {
            if link.starts_with("http") {
                continue;
            }
            let (path, heading) =
                link.split_once('#').map_or((link, None), |(path, heading)| (path, Some(heading)));
            let target = if path.is_empty() {
                page.clone()
            } else {
                format!("{folder}/{path}").trim_start_matches('/').to_owned()
            };
            assert!(at(&target).exists(), "{page}:{line}: there is no {link}");
            // mdBook turns the ending into .html, which only its own pages have.
            let leaves_the_book = folder == BOOK && path.contains('/') && path.ends_with(".md");
            assert!(!leaves_the_book, "{page}:{line}: {link} is Markdown outside the book");
            if let Some(heading) = heading {
                let there =
                    read(&target).lines().any(|line| line.starts_with('#') && anchor(line) == heading);
                assert!(there, "{page}:{line}: {target} has no heading #{heading}");
            }
        }
    }
}

#[test]
fn the_contents_name_every_page_once() {
    let contents = read(&format!("{BOOK}/SUMMARY.md"));
    let named: Vec<&str> = contents.lines().flat_map(links).collect();
    let book = pages().into_iter().filter_map(|page| page.strip_prefix("docs/src/").map(str::to_owned));
    let there: BTreeSet<String> = book.filter(|page| page != "SUMMARY.md").collect();
    assert_eq!(named.len(), there.len(), "{named:?}");
    assert_eq!(named.into_iter().map(str::to_owned).collect::<BTreeSet<_>>(), there);
}
