//! Tables on the terminal: columns as wide as their widest cell. Cells are never cut: an id that is cut cannot be
//! copied into another command.

/// Widest line of a text, in terminal cells.
pub(crate) const MAX_WIDTH: usize = 120;

/// Alignment of the text of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Align {
    /// Words.
    Left,
    /// Numbers.
    Right,
}

/// The lines with aligned columns, two spaces apart, without trailing spaces.
pub(crate) fn aligned<const N: usize>(columns: [Align; N], lines: &[[String; N]]) -> String {
    let widest = |c: usize| lines.iter().map(|l| width(&l[c])).max().unwrap_or_default();
    let widths: [usize; N] = std::array::from_fn(widest);
    let mut out = String::new();
    for line in lines {
        let mut text = String::new();
        for (c, cell) in line.iter().enumerate() {
            let pad = " ".repeat(widths[c].saturating_sub(width(cell)));
            match columns[c] {
                Align::Right => text += &format!("{pad}{cell}  "),
                Align::Left => text += &format!("{cell}{pad}  "),
            }
        }
        out.push_str(text.trim_end());
        out.push('\n');
    }
    out
}

/// `text` in lines of at most [`MAX_WIDTH`] cells, broken between words, those after the first indented.
pub(crate) fn wrapped(text: &str, indent: usize) -> String {
    let mut out = String::new();
    let words = text.trim_start_matches(' ');
    let mut line = " ".repeat(text.len() - words.len());
    for word in words.split(' ') {
        if !line.trim().is_empty() && width(&line) + 1 + width(word) > MAX_WIDTH {
            out.push_str(line.trim_end());
            out.push('\n');
            line = " ".repeat(indent) + word;
        } else {
            if !line.trim().is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    out + line.trim_end() + "\n"
}

/// Terminal cells of a text.
pub(crate) fn width(text: &str) -> usize {
    text.chars().map(char_width).sum()
}

/// Chinese characters and full-width marks take two cells.
fn char_width(c: char) -> usize {
    match c {
        '\u{2E80}'..='\u{A4CF}' | '\u{F900}'..='\u{FAFF}' | '\u{FF00}'..='\u{FF60}' => 2,
        _ => 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_by_cells_and_not_by_letters() {
        let lines = [["类别".into(), "7".into()], ["cut".into(), "12".into()]];
        assert_eq!(aligned([Align::Left, Align::Right], &lines), "类别   7\ncut   12\n");
    }

    #[test]
    fn a_long_cell_is_whole() {
        let (class, clip) = ("a".repeat(60), "b".repeat(90));
        let table = aligned([Align::Left, Align::Left], &[[class.clone(), clip.clone()]]);
        assert_eq!(table, format!("{class}  {clip}\n"));
    }

    #[test]
    fn text_is_broken_between_words() {
        let text = wrapped(&"word ".repeat(60), 2);
        assert!(text.lines().count() > 1 && text.lines().all(|l| width(l) <= MAX_WIDTH), "{text}");
        assert_eq!(text.split_whitespace().count(), 60);
        assert_eq!(wrapped("  map layers: all", 4), "  map layers: all\n");
    }
}
