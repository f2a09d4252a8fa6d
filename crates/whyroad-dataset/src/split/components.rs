//! Connected components by union and find.

/// Elements that are being joined.
pub(super) struct Components {
    parent: Vec<u32>,
}

impl Components {
    /// `n` elements, each alone.
    pub fn new(n: usize) -> Self {
        Self { parent: (0..n as u32).collect() }
    }

    fn root(&mut self, mut i: usize) -> usize {
        while self.parent[i] as usize != i {
            let grandparent = self.parent[self.parent[i] as usize];
            self.parent[i] = grandparent;
            i = grandparent as usize;
        }
        i
    }

    /// Puts two elements into one component. The smaller index becomes the root, so that the order of calls has no
    /// effect.
    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        let (low, high) = (a.min(b), a.max(b));
        self.parent[high] = low as u32;
    }

    /// The components, by their first element; elements ascending.
    pub fn groups(&mut self) -> Vec<Vec<usize>> {
        let n = self.parent.len();
        let mut place = vec![usize::MAX; n];
        let mut out: Vec<Vec<usize>> = Vec::new();
        for i in 0..n {
            let root = self.root(i);
            if place[root] == usize::MAX {
                place[root] = out.len();
                out.push(Vec::new());
            }
            out[place[root]].push(i);
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_are_one_component() {
        let mut c = Components::new(6);
        for (a, b) in [(4, 2), (2, 5), (0, 3)] {
            c.join(a, b);
        }
        assert_eq!(c.groups(), [vec![0, 3], vec![1], vec![2, 4, 5]]);
    }
}
