//! The lists of recorded formats: every page of `docs/formats/`, which has the form `# name: title`, the English text,
//! `## 中文：标题`, the Chinese text.

use super::generated;
use std::collections::BTreeMap;
use whyroad_model::Lang;

/// Name of the list, in its markers.
const LIST: &str = "formats";

/// An index page of the formats in `lang` with its list brought up to date; the error names what is wrong.
pub(in crate::cmd::taxonomy) fn fill(
    index: &str,
    pages: &BTreeMap<String, String>,
    lang: Lang,
) -> Result<String, String> {
    let line = |name: &String| Ok(format!("- [{}](../formats/{name}.md)\n", titles(name, pages)?.get(lang)));
    let list: String = pages.keys().map(line).collect::<Result<_, String>>()?;
    generated::fill(index, LIST, &format!("\n{list}\n"))
}

/// The lines of the book's summary.
pub(super) fn summary_lines(pages: &BTreeMap<String, String>) -> Result<String, String> {
    let line = |name: &String| Ok(format!("  - [{}](formats/{name}.md)\n", titles(name, pages)?.en));
    pages.keys().map(line).collect()
}

/// `name: title` in both languages, as the page's headings state it.
fn titles(name: &str, pages: &BTreeMap<String, String>) -> Result<whyroad_model::Bilingual, String> {
    let wrong = || format!("docs/formats/{name}.md does not have the form `# {name}: ...`, `## 中文：...`");
    let text = pages.get(name).ok_or_else(wrong)?;
    let heading = |start: &str| text.lines().find_map(|l| l.strip_prefix(start)).map(str::trim);
    let en = heading(&format!("# {name}: ")).ok_or_else(wrong)?;
    let zh = heading("## 中文：").ok_or_else(wrong)?;
    Ok(whyroad_model::Bilingual::new(format!("{name}：{zh}"), format!("{name}: {en}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pages(text: &str) -> BTreeMap<String, String> {
        [("mcap".to_owned(), text.to_owned())].into()
    }

    #[test]
    fn a_format_is_listed_by_its_headings() {
        let pages = pages("# mcap: MCAP recordings\n\nText.\n\n## 中文：MCAP 记录\n\n文本。\n");
        let index = "# F\n<!-- generated: formats -->\nold\n<!-- end generated -->\nrest\n";
        let filled = fill(index, &pages, Lang::Zh).unwrap();
        assert!(filled.contains("- [mcap：MCAP 记录](../formats/mcap.md)\n"), "{filled}");
        assert!(!filled.contains("old") && filled.ends_with("rest\n"), "{filled}");
        assert_eq!(summary_lines(&pages).unwrap(), "  - [mcap: MCAP recordings](formats/mcap.md)\n");
    }

    #[test]
    fn a_page_of_another_form_and_an_index_without_a_place_are_named() {
        let index = "<!-- generated: formats -->\n<!-- end generated -->\n";
        let said = fill(index, &pages("# mcap\n\n## 中文：MCAP 记录\n"), Lang::En).unwrap_err();
        assert!(said.contains("docs/formats/mcap.md"), "{said}");
        let good = pages("# mcap: M\n\n## 中文：M\n");
        assert_eq!(fill("# F\n", &good, Lang::En).unwrap_err(), "<!-- generated: formats -->");
    }
}
