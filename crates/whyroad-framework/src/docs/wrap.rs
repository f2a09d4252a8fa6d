//! Line wrapping for generated Markdown: at most [`WIDTH`] columns, where a Chinese character takes two. Code spans and
//! links are not broken. Tables and code blocks are not for this.

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

/// Marks after which a Chinese sentence is broken first: a line end there shows as the space that belongs there.
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

/// What a line may be broken between, each with whether a space stands before it.
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
    fn code_and_links_stay_whole() {
        let text = format!("{} `a b c d` and [a link](page.md#here)", "x".repeat(112));
        assert_eq!(wrap(&text, "", ""), format!("{}\n`a b c d` and [a link](page.md#here)", "x".repeat(112)));
        assert_eq!(columns("ab中文，"), 8);
    }
}
