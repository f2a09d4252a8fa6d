//! The closed list of names that a pickle may use, and the meaning of each here.

/// Meaning of a known name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Name {
    /// `numpy._core.multiarray._reconstruct`: an empty array, filled by its state.
    Reconstruct,
    /// `numpy._core.numeric._frombuffer`: an array over bytes (protocol 5).
    FromBuffer,
    /// `numpy._core.multiarray.scalar`.
    Scalar,
    /// `numpy.ndarray`, as an argument of `_reconstruct`.
    NdArray,
    /// `numpy.dtype`.
    Dtype,
    /// `_codecs.encode`: bytes in protocol 2, written as latin-1 text.
    Encode,
    /// `bytes`, `bytearray`.
    Bytes,
    /// `set`, `frozenset`, `list`, `tuple`.
    Sequence,
    /// `dict`, `OrderedDict`, ScenarioNet's own dict.
    Dict,
    /// `defaultdict`: a dict here; its factory is not called.
    DefaultDict,
    /// Types that are only ever arguments (`int` as a `defaultdict`'s factory, ...).
    Inert,
}

/// The meaning of `module.name`; `None` for everything else, which is refused.
pub(super) fn known(module: &str, name: &str) -> Option<Name> {
    // numpy 2 renamed `numpy.core` to `numpy._core`.
    let module =
        module.strip_prefix("numpy._core").map_or(module.to_owned(), |rest| format!("numpy.core{rest}"));
    Some(match (module.as_str(), name) {
        ("numpy.core.multiarray", "_reconstruct") => Name::Reconstruct,
        ("numpy.core.numeric", "_frombuffer") => Name::FromBuffer,
        ("numpy.core.multiarray", "scalar") => Name::Scalar,
        ("numpy", "ndarray") => Name::NdArray,
        ("numpy", "dtype") => Name::Dtype,
        ("_codecs", "encode") => Name::Encode,
        ("builtins" | "__builtin__", "bytes" | "bytearray") => Name::Bytes,
        ("builtins" | "__builtin__", "set" | "frozenset" | "list" | "tuple") => Name::Sequence,
        ("builtins" | "__builtin__", "dict") | ("collections", "OrderedDict") => Name::Dict,
        ("metadrive.scenario.scenario_description", "ScenarioDescription") => Name::Dict,
        ("collections", "defaultdict") => Name::DefaultDict,
        ("builtins" | "__builtin__", "int" | "float" | "str" | "bool") => Name::Inert,
        _ => return None,
    })
}
