//! Pickles written by hand from the opcode list of CPython's `pickletools`; what numpy writes is in
//! `tests/fixtures/scenarionet`, written by numpy itself.

use super::*;

fn error(bytes: &[u8]) -> PickleError {
    read(bytes).err().unwrap()
}

#[test]
fn a_command_is_refused_by_name_and_never_run() {
    // What pickle.dumps makes of an object whose __reduce__ gives (os.system, ("touch x",)), protocols 2 and 4.
    let old = b"\x80\x02cposix\nsystem\nq\x00X\x07\x00\x00\x00touch xq\x01\x85q\x02Rq\x03.";
    let new = b"\x80\x04\x95\x22\x00\x00\x00\x00\x00\x00\x00\x8c\x05posix\x94\x8c\x06system\x94\x93\x94\x8c\x07touch x\x94\x85\x94R\x94.";
    for bytes in [&old[..], &new[..]] {
        assert_eq!(error(bytes), PickleError::Forbidden("posix.system".into()));
    }
    assert_eq!(error(b"\x80\x02c__builtin__\neval\n."), PickleError::Forbidden("__builtin__.eval".into()));
    assert_eq!(error(b"\x80\x02(ibuiltins\nexec\n."), PickleError::Forbidden("builtins.exec".into()));
    for other in [&b"\x80\x02Nq\x00Q."[..], b"\x80\x05\x97.", b"\x80\x02\x82\x01."] {
        assert!(matches!(error(other), PickleError::Forbidden(_)));
    }
}

#[test]
fn a_billion_laughs_stay_sixty_lists() {
    // Sixty lists, each of which holds the one before ten times: 10^60 elements when all references are followed.
    let mut bytes = b"\x80\x02]q\x00".to_vec();
    for i in 0..60u8 {
        bytes.extend(b"](");
        bytes.extend([b'h', i].repeat(10));
        bytes.extend([b'e', b'q', i + 1]);
    }
    bytes.push(b'.');
    let pickle = read(&bytes).unwrap();
    assert_eq!(pickle.nodes.len(), 3 + 61);
    assert_eq!(pickle.root().items().unwrap().len(), 10);
    assert!(pickle.root().rows().is_none());
}

#[test]
fn a_million_references_to_one_row_do_not_become_a_million_rows() {
    // One list of 1000 numbers, in a list 1000 times: a million numbers from a file of 5 kB.
    let mut bytes = b"\x80\x02](".to_vec();
    bytes.extend([b'K', 7].repeat(1000));
    bytes.extend(b"eq\x000](");
    bytes.extend([b'h', 0].repeat(1000));
    bytes.extend(b"e.");
    let pickle = read(&bytes).unwrap();
    assert_eq!(pickle.root().items().unwrap().len(), 1000);
    assert!(pickle.root().rows().is_none());
}

#[test]
fn nesting_without_end_and_a_list_in_itself_are_harmless() {
    let deep = [&b"\x80\x02"[..], &b"]".repeat(200_000), &b"a".repeat(199_999), b"."].concat();
    assert!(read(&deep).unwrap().root().items().unwrap().len() == 1);
    let cycle = read(b"\x80\x02]q\x00h\x00a.").unwrap();
    assert!(cycle.root().items().unwrap().next().unwrap().items().is_some());
}

#[test]
fn sizes_that_lie_are_refused() {
    // A text of 4 GB in a file of 9 bytes; an array of 2^60 rows without a byte.
    assert!(matches!(error(b"\x80\x02X\xff\xff\xff\xffabc."), PickleError::Truncated(_)));
    assert!(matches!(error(b"\x80\x05\x8e\xff\xff\xff\xff\xff\xff\xff\xffa."), PickleError::Truncated(_)));
    let array = b"\x80\x03cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\x00\x85C\x01b\x87R(K\x01\x8a\x08\x00\x00\x00\x00\x00\x00\x00\x10\x85cnumpy\ndtype\nX\x02\x00\x00\x00f8\x89\x88\x87R(K\x03X\x01\x00\x00\x00<NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\x00tb\x89C\x00tb.";
    assert!(matches!(error(array), PickleError::Malformed { .. }), "{:?}", error(array));
}

#[test]
fn every_beginning_of_a_pickle_is_an_error_and_never_a_panic() {
    let whole = b"\x80\x04\x95\x22\x00\x00\x00\x00\x00\x00\x00}\x94(\x8c\x01a\x94K\x01\x8c\x01b\x94]\x94(G?\xf8\x00\x00\x00\x00\x00\x00Neu.";
    let pickle = read(whole).unwrap();
    let b: Vec<Option<f64>> = pickle.root().get("b").unwrap().items().unwrap().map(|v| v.number()).collect();
    assert_eq!((pickle.root().get("a").unwrap().number(), b), (Some(1.0), vec![Some(1.5), None]));
    for n in 0..whole.len() {
        assert!(read(&whole[..n]).is_err(), "{n}");
    }
}

proptest::proptest! {
    #[test]
    fn no_bytes_make_it_panic(bytes in proptest::collection::vec(proptest::prelude::any::<u8>(), 0..300)) {
        if let Ok(pickle) = read(&bytes) {
            let root = pickle.root();
            let _ = (root.rows(), root.texts(), root.id(), root.number(), root.text());
        }
    }
}
