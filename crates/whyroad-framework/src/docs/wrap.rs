//! Line wrapping for generated Markdown: at most [`WIDTH`] columns, where a Chinese character takes two. Code spans and
//! links are not broken. Not for tables and code blocks.

/// Columns of a line of a generated page.
pub const WIDTH: usize = 120;

/// Columns that `text` takes: two for a Chinese or full-width character, one for any other.
pub fn columns(text: &str) -> usize {
    text.chars().map(|c| if is_wide(c) { 2 } else { 1 }).sum()
}

fn is_wide(c: char) -> bool {
    matches!(u32::from(c), 0x1100..=0x115f | 0x2e80..=0xa4cf | 0xac00..=0xd7a3 | 0xf900..=0xfaff
        | 0xfe30..=0xfe6f | 0xff00..=0xff60 | 0xffe0..=0xffe6 | 0x1f300..=0x1faff | 0x20000..=0x3fffd)
}

/// Marks after which a Chinese sentence is broken first: a line end there is rendered as the space that belongs there.
const AFTER: &str = "，。；：、！？";

/// `text` (one paragraph) in lines: the first begins with `first`, the others with `rest`.
pub fn wrap(text: &str, first: &str, rest: &str) -> String {
    let mut lines: Vec<String> = Vec::new();
    let mut line = first.to_owned();
    let mut empty = true;
    for (space, piece) in pieces(text) {
        let gap = usize::from(space && !empty);
        if !empty && columns(&line) + gap + columns(&piece) > WIDTH {
            lines.push(std::mem::replace(&mut line, rest.to_owned()));
            empty = true;
        }
        if gap == 1 && !empty {
            line.push(' ');
        }
        line.push_str(&piece);
        empty = false;
    }
    lines.push(line);
    lines.join("\n")
}

/// A page with its paragraphs, list items and quotes wrapped; also after `<br>`. Tables, headings and code stay as they
/// are.
pub fn wrap_page(text: &str) -> String {
    let mut out = String::new();
    let mut fenced = false;
    for line in text.lines() {
        fenced ^= line.starts_with("```");
        let bare = line.trim_start();
        let indent = &line[..line.len() - bare.len()];
        if fenced || columns(line) <= WIDTH || bare.starts_with(['|', '#', '<']) {
            out.push_str(line);
        } else {
            let (first, rest, text) = match (bare.strip_prefix("- "), bare.strip_prefix("> ")) {
                (Some(text), _) => (format!("{indent}- "), format!("{indent}  "), text),
                (_, Some(text)) => ("> ".to_owned(), "> ".to_owned(), text),
                _ => (indent.to_owned(), indent.to_owned(), bare),
            };
            for (i, part) in text.split_inclusive("<br>").enumerate() {
                let first = if i == 0 { &first } else { &rest };
                let end = if i == 0 { "" } else { "\n" };
                out.push_str(end);
                out.push_str(&wrap(part, first, &rest));
            }
        }
        out.push('\n');
    }
    out
}

/// Two lines of a wrapped text as one: with a space, unless the first ends a Chinese clause or the break is inside one.
pub(crate) fn join(first: &mut String, next: &str) {
    let wide = |c: Option<char>| c.is_some_and(is_wide);
    let last = first.chars().next_back();
    let inside = wide(last) && wide(next.chars().next());
    if !inside && !last.is_some_and(|c| AFTER.contains(c)) {
        first.push(' ');
    }
    first.push_str(next);
}

/// Units between which a line may be broken, each with whether a space precedes it.
fn pieces(text: &str) -> Vec<(bool, String)> {
    let mut out: Vec<(bool, String)> = Vec::new();
    let (mut piece, mut space) = (String::new(), false);
    let (mut code, mut square, mut round) = (false, 0_usize, 0_usize);
    let mut flush = |piece: &mut String, space: &mut bool| {
        if !piece.is_empty() {
            out.push((std::mem::take(space), std::mem::take(piece)));
        }
    };
    for c in text.chars() {
        match c {
            '`' => code = !code,
            '[' if !code => square += 1,
            ']' if !code => square = square.saturating_sub(1),
            '(' if !code => round += 1,
            ')' if !code => round = round.saturating_sub(1),
            _ => {}
        }
        if c.is_whitespace() && !code && square == 0 {
            flush(&mut piece, &mut space);
            space = true;
            continue;
        }
        piece.push(c);
        let too_long = is_wide(c) && columns(&piece) > WIDTH / 2;
        if !code && square == 0 && round == 0 && (AFTER.contains(c) || too_long) {
            flush(&mut piece, &mut space);
        }
    }
    flush(&mut piece, &mut space);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_no_wider_than_the_page_and_lose_nothing() {
        let english = "word ".repeat(60);
        let chinese = "他车任一车轮越过车道线，自车因此减速；".repeat(20);
        for text in [english.trim(), &chinese] {
            let wrapped = wrap(text, "- ", "  ");
            assert!(wrapped.lines().all(|l| columns(l) <= WIDTH), "{wrapped}");
            assert!(wrapped.lines().count() > 1 && wrapped.starts_with("- "));
            let bare = |s: &str| s.replace(['\n', ' ', '-'], "");
            assert_eq!(bare(&wrapped), bare(text));
        }
    }

    #[test]
    fn a_page_is_wrapped_and_joined_again() {
        let clause = "关键帧为自车第一次减速的时刻，".repeat(8);
        let page =
            format!("# {clause}\n> **定义**: {clause}TTC < 5 s 之后\n- `a`: {clause}<br>x\n| {clause} |\n");
        let wrapped = wrap_page(&page);
        let wide: Vec<&str> = wrapped.lines().filter(|l| columns(l) > WIDTH).collect();
        assert!(wide.iter().all(|l| l.starts_with(['#', '|'])) && wide.len() == 2, "{wrapped}");
        let mut quote = String::new();
        for line in wrapped.lines().filter_map(|l| l.strip_prefix("> ")) {
            if quote.is_empty() { quote.push_str(line) } else { join(&mut quote, line) }
        }
        assert_eq!(quote, format!("**定义**: {clause}TTC < 5 s 之后"));
    }

    #[test]
    fn code_and_links_stay_whole() {
        let text = format!("{} `a b c d` and [a link](page.md#here)", "x".repeat(112));
        assert_eq!(wrap(&text, "", ""), format!("{}\n`a b c d` and [a link](page.md#here)", "x".repeat(112)));
        assert_eq!(columns("ab中文，"), 8);
    }
}
