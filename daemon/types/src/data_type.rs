//! A type ready for use: complete, laid out, with its codecs.

use std::fmt;
use std::sync::Arc;

use crate::cdr::plan;
use crate::equality::fingerprint;
use crate::graph::{Graph, Ix, Node, Part, Shape};
use crate::kind::{Kind, TypeId};
use crate::layout::{Layout, LayoutError};
use crate::table::TypeTable;

/// A type of a table, complete and laid out. Cloning costs one reference count.
#[derive(Clone)]
pub struct DataType {
    graph: Arc<Graph>,
    ix: Ix,
}

impl DataType {
    /// Lays out a type and everything inside it.
    ///
    /// # Errors
    /// The type, or one inside it, has no C mapping or is too large.
    pub fn new(table: &Arc<TypeTable>, id: TypeId) -> Result<Self, LayoutError> {
        Ok(Self { graph: Arc::new(Graph::new(table, id)?), ix: Graph::ROOT })
    }

    pub(crate) fn graph(&self) -> &Graph {
        &self.graph
    }

    pub(crate) fn ix(&self) -> Ix {
        self.ix
    }

    pub(crate) fn node(&self) -> &Node {
        self.graph.node(self.ix)
    }

    pub(crate) fn at(&self, ix: Ix) -> Self {
        Self { graph: Arc::clone(&self.graph), ix }
    }

    fn parts(&self) -> &[Part] {
        match &self.node().shape {
            Shape::Struct { members } | Shape::Union { members, .. } => members,
            _ => &[],
        }
    }

    /// Its IDL spelling: `sequence<long,4>`, `::demo::state`. A typedef keeps its own name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.node().name
    }

    /// Its id in [`table`](DataType::table); a typedef keeps its own id.
    #[must_use]
    pub fn id(&self) -> TypeId {
        self.node().id
    }

    /// The table that holds the type.
    #[must_use]
    pub fn table(&self) -> &Arc<TypeTable> {
        &self.graph.table
    }

    /// Kind of the type, typedefs resolved.
    #[must_use]
    pub fn kind(&self) -> &Kind {
        self.graph.table.resolved(self.id())
    }

    /// Size, alignment and offsets of members, in bytes.
    #[must_use]
    pub fn layout(&self) -> &Layout {
        &self.node().layout
    }

    /// Size in bytes, as C's `sizeof`.
    #[must_use]
    pub fn size(&self) -> usize {
        self.layout().size
    }

    /// Alignment in bytes, as C's `_Alignof`.
    #[must_use]
    pub fn align(&self) -> usize {
        self.layout().align
    }

    /// Whether a value lies completely within its [`size`](DataType::size) bytes: no unbounded
    /// string or sequence and no native inside (genom3.md 4.3).
    #[must_use]
    pub fn is_fixed_size(&self) -> bool {
        self.layout().fixed
    }

    /// Digest of the type (genom3.md 4.9).
    #[must_use]
    pub fn digest(&self) -> &str {
        self.node().digest.get_or_init(|| self.graph.table.digest(self.id()))
    }

    /// Computes what is otherwise computed on first use (digest, CDR plans), so that the first use
    /// on a real-time thread does not allocate.
    pub fn prepare(&self) {
        _ = (self.digest(), self.fingerprint());
        plan::prepare(&self.graph);
    }

    /// Number of members of a struct, exception or union; 0 for others.
    #[must_use]
    pub fn member_count(&self) -> usize {
        self.parts().len()
    }

    /// A member of a struct, exception or union.
    #[must_use]
    pub fn member(&self, index: usize) -> Option<DataType> {
        self.parts().get(index).map(|part| self.at(part.ix))
    }

    /// Name of a member of a struct, exception or union.
    #[must_use]
    pub fn member_name(&self, index: usize) -> Option<&str> {
        self.parts().get(index).map(|part| part.name.as_str())
    }

    /// Offset of a member from the start of the struct, exception or union, in bytes.
    #[must_use]
    pub fn member_offset(&self, index: usize) -> Option<usize> {
        self.parts().get(index).map(|part| part.offset)
    }

    /// Index of the member of that name.
    #[must_use]
    pub fn member_index(&self, name: &str) -> Option<usize> {
        self.parts().iter().position(|part| part.name == name)
    }

    /// Element of an array, sequence or optional.
    #[must_use]
    pub fn element(&self) -> Option<DataType> {
        match self.node().shape {
            Shape::Array { element, .. }
            | Shape::Sequence { element, .. }
            | Shape::Optional { element } => Some(self.at(element)),
            _ => None,
        }
    }

    /// Whether values of one can be copied into the other (genom3.md 4.3), also across tables.
    /// The first call caches a digest of each type; later ones compare the digests and do not
    /// allocate, except for recursive and very large types, which are compared anew.
    #[must_use]
    pub fn same_as(&self, other: &DataType) -> bool {
        if Arc::ptr_eq(&self.graph, &other.graph) && self.ix == other.ix {
            return true;
        }
        let (table, others) = (self.table(), other.table());
        if Arc::ptr_eq(table, others) && table.resolve(self.id()) == others.resolve(other.id()) {
            return true;
        }
        match (self.fingerprint(), other.fingerprint()) {
            (Some(a), Some(b)) => a == b,
            _ => table.equal_to(self.id(), others, other.id()),
        }
    }

    fn fingerprint(&self) -> Option<&str> {
        let node = self.node();
        node.fingerprint.get_or_init(|| fingerprint(self.table(), node.id)).as_deref()
    }
}

impl fmt::Debug for DataType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "DataType({})", self.name())
    }
}

impl fmt::Display for DataType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
