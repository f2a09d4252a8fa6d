//! What the known names produce from their arguments: arrays, types, bytes, containers.

use super::arena::Node;
use super::array::{Array, Data, Dtype, ElementKind};
use super::machine::{Machine, NONE, Step, TRUE};
use super::names::Name;
use super::reference::{Bytes, Ref};

impl Machine<'_> {
    fn list(&self, at: Ref) -> Step<&[Ref]> {
        match self.node(at) {
            Node::List(all) => Ok(all),
            _ => self.malformed("arguments that are not a tuple"),
        }
    }

    /// What a call of one of the known names gives. Nothing is called: each name has its meaning here.
    pub fn construct(&mut self, callee: Ref, args: Ref) -> Step<()> {
        let &Node::Name(name) = self.node(callee) else {
            return self.malformed("a call of something that is not a name");
        };
        let args: Vec<Ref> = self.list(args)?.iter().take(4).copied().collect();
        let node = match (name, &args[..]) {
            (Name::Reconstruct, _) => {
                let byte = Dtype { kind: ElementKind::Unsigned, size: 1, big_endian: false };
                let none = Data::Raw(Bytes::File(0..0));
                Node::Array(Box::new(Array { dtype: byte, shape: vec![0], fortran: false, data: none }))
            }
            (Name::FromBuffer, &[data, dtype, shape, order]) => {
                let fortran = self.text_of(order)? == "F";
                self.array(dtype, shape, fortran, data)?
            }
            (Name::Scalar, &[dtype, data]) => {
                if matches!(self.node(dtype), Node::Dtype(d) if d.kind == ElementKind::Object) {
                    self.stack.push(data);
                    return Ok(());
                }
                self.scalar(dtype, data)?
            }
            (Name::Dtype, &[code, ..]) => {
                let code = self.text_of(code)?;
                match Dtype::parse(&code) {
                    Some(d) => Node::Dtype(d),
                    None => return self.malformed(format!("numpy type '{code}', which is not read here,")),
                }
            }
            (Name::Encode, &[text, ..]) | (Name::Bytes, &[text, _, ..]) => return self.encode(text),
            (Name::Bytes, []) => Node::Bytes(Bytes::File(0..0)),
            (Name::Sequence, []) => Node::List(Vec::new()),
            (Name::Dict, []) | (Name::DefaultDict, _) => Node::Dict(Vec::new()),
            // `set([..])`, `bytes(b"..")`, `OrderedDict({..})`: the argument already is what is wanted, and a second
            // name for one object costs nothing.
            (Name::Bytes | Name::Sequence | Name::Dict, &[same]) => {
                self.stack.push(same);
                return Ok(());
            }
            _ => return self.malformed("a call that no known writer produces"),
        };
        self.push(node);
        Ok(())
    }

    /// `_codecs.encode(text, 'latin1')`: how protocol 2 writes bytes.
    fn encode(&mut self, text: Ref) -> Step<()> {
        if let Some(&done) = self.encoded.get(&text) {
            self.stack.push(done);
            return Ok(());
        }
        let start = self.decoded.len();
        for c in self.text_of(text)?.chars() {
            match u8::try_from(u32::from(c)) {
                Ok(b) => self.decoded.push(b),
                Err(_) => return self.malformed("bytes written as text with letters beyond latin-1"),
            }
        }
        let range = start..self.decoded.len();
        let done = self.push(Node::Bytes(Bytes::Decoded(range)));
        self.encoded.insert(text, done);
        Ok(())
    }

    fn dtype(&self, at: Ref) -> Step<Dtype> {
        match self.node(at) {
            Node::Dtype(d) => Ok(*d),
            _ => self.malformed("an array without a type"),
        }
    }

    fn scalar(&self, dtype: Ref, data: Ref) -> Step<Node> {
        self.shaped(self.dtype(dtype)?, Vec::new(), false, data).map(|(n, _)| n)
    }

    fn array(&mut self, dtype: Ref, shape: Ref, fortran: bool, data: Ref) -> Step<Node> {
        let mut sizes = Vec::new();
        for &r in self.list(shape)?.iter().take(8) {
            match self.node(r) {
                &Node::Int(i) if i >= 0 => sizes.push(i as usize),
                _ => return self.malformed("an array whose shape is not a list of sizes"),
            }
        }
        let (node, copied) = self.shaped(self.dtype(dtype)?, sizes, fortran, data)?;
        self.copied += copied;
        Ok(node)
    }

    /// The array, and how many references it copies.
    fn shaped(&self, dtype: Dtype, shape: Vec<usize>, fortran: bool, data: Ref) -> Step<(Node, usize)> {
        let (data, have, copied) = match (self.node(data), dtype.kind) {
            (Node::Bytes(b), kind) if kind != ElementKind::Object => {
                (Data::Raw(b.clone()), self.slice(b).len(), 0)
            }
            (Node::List(all), ElementKind::Object) => (Data::Objects(all.clone()), all.len(), all.len()),
            _ => return self.malformed("an array whose data are neither bytes nor objects"),
        };
        match Array::new(dtype, shape, fortran, data, have) {
            Ok(a) => Ok((Node::Array(Box::new(a)), copied)),
            Err(what) => self.malformed(what),
        }
    }

    /// State given to an object after it was made: an array's contents, a type's byte order.
    pub fn build(&mut self, object: Ref, state: Ref) -> Step<()> {
        let node = match self.node(object) {
            Node::Array(_) => match *self.list(state)? {
                [_, shape, dtype, fortran, data] => self.array(dtype, shape, fortran == TRUE, data)?,
                _ => return self.malformed("an array's state in a form that is not known here"),
            },
            Node::Dtype(d) => {
                let (d, state) = (*d, self.list(state)?);
                let order = match state.get(1).map(|&r| self.node(r)) {
                    Some(Node::Text(b)) => self.slice(b).to_owned(),
                    _ => return self.malformed("a numpy type without byte order"),
                };
                // Names and fields of a structured type.
                if state.iter().skip(2).take(3).any(|&r| r != NONE) {
                    return self.malformed("a structured numpy type, which is not read here,");
                }
                Node::Dtype(Dtype { big_endian: order == b">", ..d })
            }
            // Attributes of a dict that is more than a dict: not used here.
            Node::Dict(_) => return Ok(()),
            _ => return self.malformed("state for what has none"),
        };
        self.nodes[object.0 as usize] = node;
        Ok(())
    }
}
