//! What names mean, where they are read.

use std::collections::HashMap;

use super::code::{Place, Space, Type};
use super::lex::is_reserved;
use super::memory::Fixed;

/// What a name means.
#[derive(Clone, Debug)]
pub(crate) enum Name {
    Type(Type),
    /// Where it is, and what it is.
    Variable(Space, usize, Type),
    /// A number: a constant, a parameter of a template, a value that is selected.
    Number(i32),
    Function(usize),
    Channel,
}

/// Names from the outermost to the innermost block, and what they name.
#[derive(Clone, Debug, Default)]
pub(crate) struct Names {
    blocks: Vec<HashMap<String, Name>>,
    pub(crate) fixed: Fixed,
    /// First values of global numbers that are not 0.
    pub(crate) first: Vec<(usize, i32)>,
    /// Clocks, by name and index.
    pub(crate) clocks: Vec<(String, usize)>,
    /// Numbers of the function that is read.
    pub(crate) frame: usize,
    pub(crate) in_function: bool,
}

impl Names {
    pub(crate) fn open(&mut self) {
        self.blocks.push(HashMap::new());
    }

    pub(crate) fn close(&mut self) {
        self.blocks.pop();
    }

    pub(crate) fn add(&mut self, name: &str, means: Name) {
        assert!(!is_reserved(name), "`{name}` is reserved");
        let block = self.blocks.last_mut().expect("a block is open");
        assert!(block.insert(name.to_owned(), means).is_none(), "two are named `{name}`");
    }

    pub(crate) fn find(&self, name: &str) -> Option<&Name> {
        self.blocks.iter().rev().find_map(|block| block.get(name))
    }

    /// A variable of the block that is read.
    pub(crate) fn variable(&mut self, name: &str, of: &Type) -> Place {
        let (space, base) = match of {
            Type::Clock | Type::Channel | Type::Void => panic!("{name}: {of:?} is not known here"),
            Type::Array(inner, count) if **inner == Type::Clock => {
                assert!(!self.in_function, "{name}: a clock in a function");
                let base = self.clocks.len();
                self.clocks.extend((0..*count).map(|at| (name.to_owned(), at)));
                (Space::Clock, base)
            }
            _ if self.in_function => {
                assert_eq!(of.size(), 1, "{name}: functions have numbers only");
                self.frame += 1;
                (Space::Local, self.frame - 1)
            }
            _ => {
                self.fixed.ranges.extend(of.ranges());
                (Space::Global, self.fixed.ranges.len() - of.size())
            }
        };
        self.add(name, Name::Variable(space, base, of.clone()));
        Place { space, base, indices: Vec::new(), of: of.clone() }
    }

    /// A table of constants.
    pub(crate) fn table(&mut self, name: &str, of: &Type, values: &[i32]) {
        assert_eq!(of.size(), values.len(), "{name} has other values than places");
        let base = self.fixed.constants.len();
        self.fixed.constants.extend(values);
        self.add(name, Name::Variable(Space::Constant, base, of.clone()));
    }
}
