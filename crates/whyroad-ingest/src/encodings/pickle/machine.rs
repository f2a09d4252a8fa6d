//! The stack machine that a pickle is a program for: opcodes 2 to 5 without those that import, call or look outside.

use super::arena::{Node, Pickle, PickleError};
use super::names::known;
use super::reference::{Bytes, Ref};
use std::collections::HashMap;
use std::ops::Range;

/// A pickle with more objects than this is not a recording of a drive.
const MAX_OBJECTS: usize = 50_000_000;

pub(super) const NONE: Ref = Ref(0);
const FALSE: Ref = Ref(1);
pub(super) const TRUE: Ref = Ref(2);

pub(super) struct Machine<'a> {
    file: &'a [u8],
    at: usize,
    pub decoded: Vec<u8>,
    pub nodes: Vec<Node>,
    pub stack: Vec<Ref>,
    /// Heights of the stack at the open marks.
    marks: Vec<usize>,
    memo: HashMap<u64, Ref>,
    /// Texts that were converted to bytes, so that each text is converted only once.
    pub encoded: HashMap<Ref, Ref>,
    /// Copies of references that were made beyond what the file itself writes out.
    pub copied: usize,
}

pub(super) type Step<T> = Result<T, PickleError>;

/// Runs the program.
pub(super) fn run(file: &[u8]) -> Step<Pickle<'_>> {
    let mut m = Machine {
        file,
        at: 0,
        decoded: Vec::new(),
        nodes: vec![Node::None, Node::Bool(false), Node::Bool(true)],
        stack: Vec::new(),
        marks: Vec::new(),
        memo: HashMap::new(),
        encoded: HashMap::new(),
        copied: 0,
    };
    let root = m.run()?;
    Ok(Pickle { file, decoded: m.decoded, nodes: m.nodes, root })
}

impl Machine<'_> {
    pub fn malformed<T>(&self, what: impl Into<String>) -> Step<T> {
        Err(PickleError::Malformed { what: what.into(), at: self.at })
    }

    fn run(&mut self) -> Step<Ref> {
        loop {
            let [op] = self.fixed::<1>()?;
            match op {
                b'.' => return self.pop(),
                0x80 => {
                    let [version] = self.fixed::<1>()?;
                    if version > 5 {
                        return self.malformed(format!("protocol {version}, which is not known here,"));
                    }
                }
                // A frame only says how much to read at once.
                0x95 => drop(self.fixed::<8>()?),
                _ => self.step(op)?,
            }
            if self.nodes.len() + self.copied > MAX_OBJECTS {
                return Err(PickleError::TooLarge(MAX_OBJECTS));
            }
        }
    }

    fn step(&mut self, op: u8) -> Step<()> {
        match op {
            b'N' => self.stack.push(NONE),
            0x88 => self.stack.push(TRUE),
            0x89 => self.stack.push(FALSE),
            b'J' => self.int(|m| Ok(i64::from(i32::from_le_bytes(m.fixed()?))))?,
            b'K' => self.int(|m| Ok(i64::from(u8::from_le_bytes(m.fixed()?))))?,
            b'M' => self.int(|m| Ok(i64::from(u16::from_le_bytes(m.fixed()?))))?,
            0x8a => {
                let [n] = self.fixed::<1>()?;
                self.long(usize::from(n))?;
            }
            0x8b => {
                let n = self.length::<4>()?;
                self.long(n)?;
            }
            b'G' => {
                let v = f64::from_be_bytes(self.fixed()?);
                self.push(Node::Float(v));
            }
            // Python 2's short strings are texts here; what is not UTF-8 shows as such.
            0x8c | b'U' => self.text::<1>()?,
            b'X' | b'T' => self.text::<4>()?,
            0x8d => self.text::<8>()?,
            b'C' => self.raw::<1>()?,
            b'B' => self.raw::<4>()?,
            0x8e | 0x96 => self.raw::<8>()?,
            b'(' => self.marks.push(self.stack.len()),
            b'0' => drop(self.pop()?),
            b'1' => drop(self.since_mark()?),
            b'2' => {
                let top = self.top()?;
                self.stack.push(top);
            }
            b']' | b')' | 0x8f => drop(self.push(Node::List(Vec::new()))),
            b'}' => drop(self.push(Node::Dict(Vec::new()))),
            b'l' | b't' | 0x91 => {
                let items = self.since_mark()?;
                self.push(Node::List(items));
            }
            0x85..=0x87 => {
                let mut items = Vec::with_capacity(3);
                for _ in 0..op - 0x84 {
                    items.push(self.pop()?);
                }
                items.reverse();
                self.push(Node::List(items));
            }
            b'd' => {
                let items = self.since_mark()?;
                let dict = self.push(Node::Dict(Vec::new()));
                self.set_items(dict, &items)?;
            }
            b'a' => {
                let item = self.pop()?;
                self.append(&[item])?;
            }
            b'e' | 0x90 => {
                let items = self.since_mark()?;
                self.append(&items)?;
            }
            b's' => {
                let (value, key) = (self.pop()?, self.pop()?);
                let dict = self.top()?;
                self.set_items(dict, &[key, value])?;
            }
            b'u' => {
                let items = self.since_mark()?;
                let dict = self.top()?;
                self.set_items(dict, &items)?;
            }
            0x94 => {
                let (key, top) = (self.memo.len() as u64, self.top()?);
                self.memo.insert(key, top);
            }
            b'q' => self.put::<1>()?,
            b'r' => self.put::<4>()?,
            b'h' => self.get::<1>()?,
            b'j' => self.get::<4>()?,
            b'c' => {
                let (module, name) = (self.line()?, self.line()?);
                self.name(&module, &name)?;
            }
            0x93 => {
                let (name, module) = (self.pop()?, self.pop()?);
                let (module, name) = (self.text_of(module)?, self.text_of(name)?);
                self.name(&module, &name)?;
            }
            b'R' | 0x81 => {
                let (args, callee) = (self.pop()?, self.pop()?);
                self.construct(callee, args)?;
            }
            b'b' => {
                let (state, object) = (self.pop()?, self.top()?);
                self.build(object, state)?;
            }
            b'i' => {
                let (module, name) = (self.line()?, self.line()?);
                return Err(PickleError::Forbidden(format!("{module}.{name}")));
            }
            b'P' | b'Q' => {
                return Err(PickleError::Forbidden("an object outside the file (persistent id)".into()));
            }
            0x82..=0x84 => return Err(PickleError::Forbidden("a name from the extension registry".into())),
            0x97 | 0x98 => return Err(PickleError::Forbidden("a buffer outside the file".into())),
            b'I' | b'L' | b'F' | b'S' | b'V' | b'p' | b'g' => {
                return self.malformed("a pickle of protocol 0 or 1, which is not read here,");
            }
            _ => return self.malformed(format!("an opcode that is not known here (0x{op:02x})")),
        }
        Ok(())
    }

    fn take(&mut self, n: usize) -> Step<Range<usize>> {
        match self.at.checked_add(n).filter(|&end| end <= self.file.len()) {
            Some(end) => Ok(std::mem::replace(&mut self.at, end)..end),
            None => Err(PickleError::Truncated(self.file.len())),
        }
    }

    fn fixed<const N: usize>(&mut self) -> Step<[u8; N]> {
        let range = self.take(N)?;
        let mut out = [0; N];
        out.copy_from_slice(&self.file[range]);
        Ok(out)
    }

    /// A length of N bytes, little endian.
    fn length<const N: usize>(&mut self) -> Step<usize> {
        let mut wide = [0; 8];
        wide[..N].copy_from_slice(&self.fixed::<N>()?);
        usize::try_from(u64::from_le_bytes(wide)).or_else(|_| self.malformed("a length beyond this machine"))
    }

    fn line(&mut self) -> Step<String> {
        let rest = &self.file[self.at..];
        let end = rest.iter().position(|&b| b == b'\n').ok_or(PickleError::Truncated(self.file.len()))?;
        let range = self.take(end + 1)?;
        Ok(String::from_utf8_lossy(&self.file[range.start..range.end - 1]).into_owned())
    }

    pub fn push(&mut self, node: Node) -> Ref {
        let at = Ref(self.nodes.len() as u32);
        self.nodes.push(node);
        self.stack.push(at);
        at
    }

    fn top(&self) -> Step<Ref> {
        let floor = self.marks.last().copied().unwrap_or(0);
        match self.stack.last() {
            Some(&r) if self.stack.len() > floor => Ok(r),
            _ => self.malformed("an operation on an empty stack"),
        }
    }

    fn pop(&mut self) -> Step<Ref> {
        let top = self.top()?;
        self.stack.pop();
        Ok(top)
    }

    fn since_mark(&mut self) -> Step<Vec<Ref>> {
        match self.marks.pop() {
            Some(height) => Ok(self.stack.split_off(height.min(self.stack.len()))),
            None => self.malformed("the end of a list that has no beginning"),
        }
    }

    fn int(&mut self, read: impl FnOnce(&mut Self) -> Step<i64>) -> Step<()> {
        let v = read(self)?;
        self.push(Node::Int(v));
        Ok(())
    }

    /// Two's complement of n bytes. No recording has numbers beyond 64 bits.
    fn long(&mut self, n: usize) -> Step<()> {
        let range = self.take(n)?;
        let raw = &self.file[range];
        if n > 8 {
            return self.malformed("a whole number of more than 64 bits");
        }
        let fill = if raw.last().is_some_and(|b| b & 0x80 != 0) { 0xff } else { 0 };
        let mut wide = [fill; 8];
        wide[..n].copy_from_slice(raw);
        self.push(Node::Int(i64::from_le_bytes(wide)));
        Ok(())
    }

    fn text<const N: usize>(&mut self) -> Step<()> {
        let n = self.length::<N>()?;
        let range = self.take(n)?;
        self.push(Node::Text(Bytes::File(range)));
        Ok(())
    }

    fn raw<const N: usize>(&mut self) -> Step<()> {
        let n = self.length::<N>()?;
        let range = self.take(n)?;
        self.push(Node::Bytes(Bytes::File(range)));
        Ok(())
    }

    fn put<const N: usize>(&mut self) -> Step<()> {
        let (key, top) = (self.length::<N>()? as u64, self.top()?);
        self.memo.insert(key, top);
        Ok(())
    }

    fn get<const N: usize>(&mut self) -> Step<()> {
        let key = self.length::<N>()? as u64;
        match self.memo.get(&key) {
            Some(&r) => self.stack.push(r),
            None => return self.malformed(format!("a reference to object {key}, which was not kept,")),
        }
        Ok(())
    }

    fn append(&mut self, items: &[Ref]) -> Step<()> {
        let list = self.top()?;
        match &mut self.nodes[list.0 as usize] {
            Node::List(all) => all.extend_from_slice(items),
            _ => return self.malformed("an element for something that is not a list"),
        }
        Ok(())
    }

    fn set_items(&mut self, dict: Ref, items: &[Ref]) -> Step<()> {
        if !items.len().is_multiple_of(2) {
            return self.malformed("a key without a value");
        }
        match &mut self.nodes[dict.0 as usize] {
            Node::Dict(all) => all.extend(items.chunks_exact(2).map(|c| (c[0], c[1]))),
            _ => return self.malformed("an entry for something that is not a dict"),
        }
        Ok(())
    }

    pub fn node(&self, at: Ref) -> &Node {
        &self.nodes[at.0 as usize]
    }

    pub fn slice(&self, b: &Bytes) -> &[u8] {
        match b {
            Bytes::File(r) => &self.file[r.clone()],
            Bytes::Decoded(r) => &self.decoded[r.clone()],
        }
    }

    pub fn text_of(&self, at: Ref) -> Step<String> {
        match self.node(at) {
            Node::Text(b) => Ok(String::from_utf8_lossy(self.slice(b)).into_owned()),
            _ => self.malformed("a name that is not text"),
        }
    }

    fn name(&mut self, module: &str, name: &str) -> Step<()> {
        let known = known(module, name).ok_or_else(|| PickleError::Forbidden(format!("{module}.{name}")))?;
        self.push(Node::Name(known));
        Ok(())
    }
}
