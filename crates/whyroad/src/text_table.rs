//! Tables on the terminal: columns as wide as their widest cell, within a maximum width.

/// Widest line of a table, in terminal cells.
pub(crate) const MAX_WIDTH: usize = 120;

/// Alignment of the text of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Align {
    /// Words.
    Left,
    /// Numbers.
    Right,
    /// Words that may be shortened in the middle where the table would be too wide.
    Shrink,
}

/// The lines with aligned columns, two spaces apart, without trailing spaces.
pub(crate) fn aligned<const N: usize>(columns: [Align; N], lines: &[[String; N]]) -> String {
    let widest = |c: usize| lines.iter().map(|l| width(&l[c])).max().unwrap_or_default();
    let mut widths: [usize; N] = std::array::from_fn(widest);
    let gaps = 2 * N.saturating_sub(1);
    for (c, align) in columns.iter().enumerate() {
        let others: usize = widths.iter().sum::<usize>() - widths[c] + gaps;
        if *align == Align::Shrink && others + widths[c] > MAX_WIDTH {
            widths[c] = MAX_WIDTH.saturating_sub(others).max(8);
        }
    }
    let mut out = String::new();
    for line in lines {
        let mut text = String::new();
        for (c, cell) in line.iter().enumerate() {
            let cell = shortened(cell, widths[c]);
            let pad = " ".repeat(widths[c].saturating_sub(width(&cell)));
            match columns[c] {
                Align::Right => text += &format!("{pad}{cell}  "),
                Align::Left | Align::Shrink => text += &format!("{cell}{pad}  "),
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

/// `text` in at most `cells` cells: its start and its end, which distinguish ids.
fn shortened(text: &str, cells: usize) -> String {
    if width(text) <= cells {
        return text.to_owned();
    }
    let half = cells.saturating_sub(1) / 2;
    let taken = |chars: &mut dyn Iterator<Item = char>| {
        let mut room = half;
        let fits = chars.take_while(|c| {
            let fits = room.checked_sub(char_width(*c));
            room = fits.unwrap_or(0);
            fits.is_some()
        });
        fits.collect::<Vec<_>>()
    };
    let start: String = taken(&mut text.chars()).into_iter().collect();
    let end: String = taken(&mut text.chars().rev()).into_iter().rev().collect();
    format!("{start}…{end}")
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
    fn a_long_cell_keeps_its_start_and_its_end() {
        let lines = [["a".repeat(60), format!("{}-end", "b".repeat(90))]];
        let table = aligned([Align::Left, Align::Shrink], &lines);
        assert_eq!(width(table.trim_end()), MAX_WIDTH - 1);
        assert!(table.contains("b…b") && table.trim_end().ends_with("-end"), "{table}");
    }

    #[test]
    fn text_is_broken_between_words() {
        let text = wrapped(&"word ".repeat(60), 2);
        assert!(text.lines().count() > 1 && text.lines().all(|l| width(l) <= MAX_WIDTH), "{text}");
        assert_eq!(text.split_whitespace().count(), 60);
        assert_eq!(wrapped("  map layers: all", 4), "  map layers: all\n");
    }
}
