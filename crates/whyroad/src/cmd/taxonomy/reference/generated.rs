//! Parts of a written page that are generated: between `<!-- generated: name -->` and `<!-- end generated -->`, each on
//! a line of its own.

const END: &str = "<!-- end generated -->";

/// `page` with the part `name` replaced by `content`; the error is the marker that the page lacks.
pub(super) fn fill(page: &str, name: &str, content: &str) -> Result<String, String> {
    let marker = format!("<!-- generated: {name} -->");
    let start = page.find(&format!("{marker}\n")).ok_or_else(|| marker.clone())? + marker.len() + 1;
    let end = page[start..].find(END).ok_or_else(|| END.to_owned())? + start;
    // The end marker keeps its indentation.
    let end = page[..end].rfind('\n').map_or(end, |line| line + 1).max(start);
    Ok(format!("{}{content}{}", &page[..start], &page[end..]))
}
