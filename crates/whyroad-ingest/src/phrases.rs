//! Reasons for which decoders and parsers stop, in Chinese. They are made in English, far from the message that names
//! them; names, numbers and values in them stay as they are.

use std::borrow::Cow;

/// English and Chinese; `{}` stands for any text, which is looked up in its turn. The first one that fits is used.
const PHRASES: &[(&str, &str)] = &[
    // What a cell should have been.
    ("a number", "数字"),
    ("an integer", "整数"),
    ("a text", "文本"),
    ("true or false", "true 或 false"),
    ("a whole number of nanoseconds", "整数纳秒"),
    ("a number of seconds", "秒数"),
    ("an ISO 8601 time with an offset from UTC", "带 UTC 偏移的 ISO 8601 时间"),
    ("values of type {} are not {}", "类型为 {} 的值不是{}"),
    // Texts that are not UTF-8.
    ("line {} is not UTF-8 text; save the file as UTF-8", "第 {} 行不是 UTF-8 文本；请将文件另存为 UTF-8"),
    ("it is UTF-16 text; save it as UTF-8", "是 UTF-16 文本；请另存为 UTF-8"),
    // Tables.
    ("column '{}' is missing", "缺少列 '{}'"),
    ("column '{}': {}", "列 '{}'：{}"),
    ("the file does not begin as an Arrow IPC (feather) file", "文件开头不是 Arrow IPC（feather）文件"),
    ("its content contradicts its schema", "内容与其结构不符"),
    ("it unpacks to far more than a table of this size can hold", "解压后远大于此大小的表所能容纳的内容"),
    ("it repeats long texts until they fill the memory", "重复长文本，直至占满内存"),
    ("it is too short", "文件过短"),
    ("its footer is longer than the file", "文件尾比文件还长"),
    ("its footer is broken: {}", "文件尾损坏：{}"),
    ("one of its messages is cut short", "其中一条消息被截断"),
    ("one of its messages is broken: {}", "其中一条消息损坏：{}"),
    ("one of its messages has no record batch", "其中一条消息没有记录批"),
    ("it declares more rows than it has bytes for", "声明的行数超过字节所能容纳"),
    ("one of its buffers is not inside its message", "其中一个缓冲区不在其消息之内"),
    ("one of its packed buffers is cut short", "其中一个压缩缓冲区被截断"),
    (
        "one of its buffers of {} bytes declares {} unpacked bytes",
        "其中一个 {} 字节的缓冲区声明解压后有 {} 字节",
    ),
    ("its header has no time and no 'timestep_time'", "表头既没有 time 也没有 'timestep_time'"),
    ("line {} breaks off", "第 {} 行中断"),
    ("at line {}: {}", "第 {} 行：{}"),
    ("at byte {}: {}", "第 {} 字节处：{}"),
    ("row {} has no id or chunk", "第 {} 行没有编号或分块"),
    ("more rows than the file has bytes", "行数多于文件字节数"),
    ("no id, or one that another object has", "没有编号，或编号与另一对象相同"),
    // CSV and JSON parsers.
    (
        "CSV error: record {} (line: {}, byte: {}): found record with {} fields, but the previous record has {} fields",
        "CSV 第 {} 条记录（第 {} 行，第 {} 字节）：有 {3} 个字段，而前一条记录有 {4} 个",
    ),
    (
        "CSV parse error: record {} (line {}, field: {}, byte: {}): {}",
        "CSV 第 {} 条记录（第 {} 行，字段 {}，第 {} 字节）：{}",
    ),
    ("CSV error: {}", "CSV 错误：{}"),
    ("{} at line {} column {}", "第 {1} 行第 {2} 列：{0}"),
    ("EOF while parsing an object", "对象未结束，文件已到末尾"),
    ("EOF while parsing a list", "列表未结束，文件已到末尾"),
    ("EOF while parsing a string", "字符串未结束，文件已到末尾"),
    ("EOF while parsing a value", "缺少值，文件已到末尾"),
    ("expected value", "此处应为一个值"),
    ("expected ident", "此处应为 true、false 或 null"),
    ("expected `:`", "此处应为“:”"),
    ("expected `,` or `}`", "此处应为“,”或“}”"),
    ("expected `,` or `]`", "此处应为“,”或“]”"),
    ("key must be a string", "键必须是字符串"),
    ("trailing comma", "多余的逗号"),
    ("trailing characters", "值之后有多余的字符"),
    ("invalid escape", "无效的转义"),
    ("invalid number", "无效的数字"),
    ("number out of range", "数字超出范围"),
    ("invalid unicode code point", "无效的 Unicode 码位"),
    ("control character (\\u0000-\\u001F) found while parsing a string", "字符串中有控制字符"),
    ("recursion limit exceeded", "嵌套过深"),
    ("missing field `{}`", "缺少字段 `{}`"),
    ("unknown field `{}`, expected {}", "未知字段 `{}`，应为 {}"),
    ("duplicate field `{}`", "字段 `{}` 重复"),
    ("invalid type: {}, expected {}", "类型不符：{}，应为 {}"),
    ("invalid value: {}, expected {}", "值不符：{}，应为 {}"),
    ("invalid length {}, expected {}", "长度不符：{}，应为 {}"),
    ("stream did not contain valid UTF-8", "不是 UTF-8 文本；请将文件另存为 UTF-8"),
    // The system.
    ("No such file or directory (os error {})", "没有该文件或文件夹 (os error {})"),
    ("Permission denied (os error {})", "没有权限 (os error {})"),
    ("Is a directory (os error {})", "是文件夹 (os error {})"),
    ("failed to fill whole buffer", "文件提前结束"),
    ("unexpected end of file", "文件提前结束"),
    // Containers of messages.
    ("it does not begin as an MCAP file", "文件开头不是 MCAP 文件"),
    ("it does not begin as a ROS bag of format 2.0", "文件开头不是 2.0 格式的 ROS bag"),
    ("it ends inside a record that begins at byte {}", "文件在始于第 {} 字节的记录中间结束"),
    ("the chunk at byte {} cannot be unpacked: {}", "第 {} 字节处的数据块无法解压：{}"),
    ("the record at byte {} is not an MCAP record", "第 {} 字节处的记录不是 MCAP 记录"),
    ("the record at byte {} is not a bag record", "第 {} 字节处的记录不是 bag 记录"),
    (
        "the record at byte {} needs {} bytes, the file has {} left",
        "第 {} 字节处的记录需要 {} 字节，文件只剩 {} 字节",
    ),
    ("the length of the record at byte {} does not fit its checksum", "第 {} 字节处记录的长度与校验和不符"),
    ("the record at byte {} does not fit its checksum", "第 {} 字节处的记录与校验和不符"),
    ("it does not fit its checksum", "与校验和不符"),
    ("its header is cut short", "头部被截断"),
    ("its header has no size", "头部没有大小"),
    ("its header has no compression", "头部没有压缩方式"),
    ("it declares {} bytes", "声明有 {} 字节"),
    ("compression '{}' is not known", "未知的压缩方式 '{}'"),
    ("its size differs from the declared size", "大小与声明的不同"),
    ("a record in it is cut short", "其中一条记录被截断"),
    ("a record in it is malformed", "其中一条记录格式错误"),
    ("a message ends inside a field", "消息在字段中间结束"),
    ("a field has an encoding that is not known (wire type {})", "字段的编码未知（wire type {}）"),
    ("field {} is of another type than the schema says", "字段 {} 的类型与 schema 不同"),
    ("it does not begin as bzip2", "开头不是 bzip2"),
    ("it is cut short", "被截断"),
    ("a block {}", "压缩块损坏（a block {}）"),
    ("member '{}' has {} bytes, more than {}", "成员 '{}' 有 {} 字节，超过 {}"),
    ("member '{}' has {} bytes instead of {}", "成员 '{}' 有 {} 字节，而不是 {}"),
    ("the file ends inside an element", "文件在元素中间结束"),
    ("the file has no XML element", "文件中没有 XML 元素"),
    ("the file ends inside the array", "文件在数组中间结束"),
    ("the file ends in its header", "文件在头部结束"),
    ("an array of {} dimensions where one or two are expected", "数组有 {} 维，应为一维或二维"),
    ("an array larger than memory", "数组大于内存"),
    // Pickles.
    ("it asks for '{}', which is not plain data", "它要求 '{}'，这不是普通数据"),
    ("it ends too early, at byte {}", "在第 {} 字节处过早结束"),
    ("it makes more than {} objects", "对象多于 {} 个"),
    ("{} at byte {}", "第 {1} 字节处：{0}"),
    // Scenarios and maps.
    ("is not a dict", "不是字典"),
    ("has no times", "没有时间"),
    ("does not rise all the time", "没有始终递增"),
    ("it has no state", "没有状态"),
    ("it has no position", "没有位置"),
    ("it has no times or no tracks", "没有时间或没有轨迹"),
    ("its times do not rise", "时间没有递增"),
    ("{} has {} rows, the scenario {}", "{} 有 {} 行，场景有 {} 行"),
    ("{} is not a table of numbers", "{} 不是数字表"),
    ("{} of {} points", "{}只有 {} 个点"),
    ("{} with a point that is not a number", "{}有一个点不是数字"),
    ("a lane", "车道"),
    ("a line", "线"),
    ("a crosswalk", "人行横道"),
    ("an area", "区域"),
    ("a sign", "标志"),
    ("a second track {}", "轨迹 {} 出现第二次"),
    ("a repeated or backward time step", "时间步重复或倒退"),
    ("object '{}' is missing", "缺少对象 '{}'"),
    ("its quaternion is not a rotation", "四元数不是旋转"),
    ("it has {} bytes", "有 {} 字节"),
    ("it has no '{}'", "没有 '{}'"),
    ("it is neither OpenDRIVE nor Lanelet2 (OSM XML)", "既不是 OpenDRIVE 也不是 Lanelet2（OSM XML）"),
    ("way {} is not in the file", "文件中没有 way {}"),
    ("it has no {} bound", "没有{}边界"),
    ("its {} bound has nodes without a position", "{}边界有没有位置的节点"),
    ("its {} bound has fewer than two nodes", "{}边界的节点少于两个"),
    ("its {} bound has more than {} ways", "{}边界的 way 多于 {} 条"),
    ("its {} bound names a way twice", "{}边界两次引用同一 way"),
    ("its {} bound has {} points", "{}边界有 {} 个点"),
    (
        "the ways of its {} bound do not meet end to end; join or reorder them",
        "{}边界的各 way 首尾不相接；请连接或重新排序",
    ),
    ("left", "左"),
    ("right", "右"),
    ("lane '{}' has fewer than two points", "车道 '{}' 少于两个点"),
    ("it is empty", "文件是空的"),
    ("it has no lanes", "其中没有车道"),
    ("it is a Parquet file; give it the ending .parquet", "这是 Parquet 文件；请以 .parquet 为扩展名"),
    (
        "its columns are separated by {}; save it with commas and decimal points",
        "各列以{}分隔；请以逗号分隔、以小数点书写小数后保存",
    ),
    ("semicolons", "分号"),
    ("tabs", "制表符"),
    ("bars", "竖线"),
    ("a number above 0", "大于 0 的数"),
    ("a number from 0 in m or m/s", "不小于 0 的数，单位 m 或 m/s"),
    ("expected degrees, as in {}", "应为度数，例如 {}"),
    ("expected meters, as in {}", "应为以米为单位的两个数，例如 {}"),
    ("expected wgs84 or gcj02", "应为 wgs84 或 gcj02"),
    ("expected utm or local", "应为 utm 或 local"),
    // Places in a file, last: they fit almost anything.
    ("{} without {}", "{} 没有 {}"),
    ("row {}, track {}: {}", "第 {} 行，轨迹 {}：{}"),
    ("row {}: {}", "第 {} 行：{}"),
    ("row {}", "第 {} 行"),
    ("{} at {} s", "{}，{} s 处"),
    ("{}: {}", "{}：{}"),
];

/// A reason in Chinese; as it is where the phrase is not known.
pub(crate) fn zh(text: &str) -> String {
    in_chinese(text).into_owned()
}

fn in_chinese(text: &str) -> Cow<'_, str> {
    let found = PHRASES.iter().find_map(|(en, zh)| Some((*zh, captures(en, text)?)));
    found.map_or(Cow::Borrowed(text), |(zh, parts)| Cow::Owned(filled(zh, &parts)))
}

/// The texts at the `{}` of a pattern; each is as short as possible, and none is empty.
fn captures<'t>(pattern: &str, text: &'t str) -> Option<Vec<&'t str>> {
    let mut literals = pattern.split("{}");
    let mut rest = text.strip_prefix(literals.next()?)?;
    let mut found = Vec::new();
    let literals: Vec<&str> = literals.collect();
    for (k, literal) in literals.iter().enumerate() {
        let is_last = k + 1 == literals.len();
        let at = if is_last {
            rest.len().checked_sub(literal.len()).filter(|_| rest.ends_with(literal))?
        } else {
            rest.find(literal)?
        };
        if at == 0 {
            return None;
        }
        found.push(&rest[..at]);
        rest = &rest[at + literal.len()..];
    }
    rest.is_empty().then_some(found)
}

/// The pattern with these parts in Chinese at its `{}`, in order, or at `{n}`.
fn filled(pattern: &str, parts: &[&str]) -> String {
    let (mut out, mut rest, mut next) = (String::new(), pattern, 0);
    while let Some((before, after)) = rest.split_once('{') {
        let Some((name, behind)) = after.split_once('}').filter(|(name, _)| name.len() < 2) else {
            break;
        };
        let index = name.parse().unwrap_or(next);
        next += 1;
        out.push_str(before);
        out.push_str(&in_chinese(parts.get(index).copied().unwrap_or_default()));
        rest = behind;
    }
    out.push_str(rest);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_are_given_in_chinese_with_their_names_and_numbers() {
        for (en, expected) in [
            ("a number", "数字"),
            ("it ends inside a record that begins at byte 42", "文件在始于第 42 字节的记录中间结束"),
            (
                "the chunk at byte 42 cannot be unpacked: it does not fit its checksum",
                "第 42 字节处的数据块无法解压：与校验和不符",
            ),
            ("EOF while parsing an object at line 3 column 7", "第 3 行第 7 列：对象未结束，文件已到末尾"),
            ("row 0, track 7: its quaternion is not a rotation", "第 0 行，轨迹 7：四元数不是旋转"),
            ("expected `,` or `}` at line 1 column 2", "第 1 行第 2 列：此处应为“,”或“}”"),
            (
                "CSV error: record 2 (line: 3, byte: 9): found record with 2 fields, but the previous record has 3 fields",
                "CSV 第 2 条记录（第 3 行，第 9 字节）：有 2 个字段，而前一条记录有 3 个",
            ),
            ("something of a library", "something of a library"),
        ] {
            assert_eq!(zh(en), expected);
        }
    }

    /// No pattern has more gaps in Chinese, and none is hidden by an earlier one.
    #[test]
    fn phrases_are_well_formed() {
        for (k, (en, zh)) in PHRASES.iter().enumerate() {
            let gaps = en.matches("{}").count();
            assert!(zh.matches('{').count() <= gaps, "{en}");
            let sample = en.replace("{}", "X");
            let first = PHRASES.iter().position(|(of, _)| captures(of, &sample).is_some());
            assert_eq!(first, Some(k), "{en} is hidden by an earlier phrase");
        }
    }
}
