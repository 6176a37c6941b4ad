//! Typed indices of ports, services, tasks, remotes, codels and states into the lists of a
//! component: the compiler refuses one in place of another.

use std::fmt;
use std::iter::FromIterator;
use std::marker::PhantomData;
use std::ops::{Deref, DerefMut, Index, IndexMut};

/// An index into an [`Indexed`] list.
pub trait Ix: Copy + Eq + fmt::Debug {
    /// The index with this number: for code that makes the list, or that restores a number which
    /// [`index`](Self::index) returned.
    fn new(index: usize) -> Self;

    /// Its number, counted from 0.
    fn index(self) -> usize;
}

macro_rules! places {
    ($($(#[$doc:meta])* $name:ident;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[repr(transparent)]
        pub struct $name(usize);

        impl Ix for $name {
            #[inline]
            fn new(index: usize) -> Self {
                Self(index)
            }

            #[inline]
            fn index(self) -> usize {
                self.0
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        }
    )*};
}

places! {
    /// Index of a port in [`Component::ports`](super::Component::ports).
    PortIx;
    /// Index of a service in [`Component::services`](super::Component::services).
    ServiceIx;
    /// Index of a task in [`Component::tasks`](super::Component::tasks).
    TaskIx;
    /// Index of a remote in [`Component::remotes`](super::Component::remotes).
    RemoteIx;
    /// Index of a codel in [`Component::codels`](super::Component::codels).
    CodelIx;
    /// Index of a state in [`Component::states`](super::Component::states).
    StateIx;
}

/// A list that can be indexed with one type of index only.
///
/// ```
/// use genom_description::model::{Indexed, Ix as _, PortIx};
///
/// let names: Indexed<PortIx, &str> = ["pose", "map"].into_iter().collect();
/// let map = names.find(|name| *name == "map").unwrap();
/// assert_eq!((map.index(), names[map]), (1, "map"));
/// // `map` makes a list with the same indices.
/// let lengths = names.map(|_, name| name.len());
/// assert_eq!(lengths[map], 3);
/// ```
#[derive(Clone, PartialEq, Eq)]
#[repr(transparent)]
pub struct Indexed<I, T> {
    list: Vec<T>,
    place: PhantomData<fn(I) -> I>,
}

impl<I: Ix, T> Indexed<I, T> {
    /// The element at an index; `None` beyond the end.
    #[must_use]
    #[inline]
    pub fn get(&self, ix: I) -> Option<&T> {
        self.list.get(ix.index())
    }

    /// Mutable reference to the element at an index; `None` beyond the end.
    #[must_use]
    #[inline]
    pub fn get_mut(&mut self, ix: I) -> Option<&mut T> {
        self.list.get_mut(ix.index())
    }

    /// Adds an element at the end; returns its index.
    pub fn push(&mut self, element: T) -> I {
        self.list.push(element);
        I::new(self.list.len() - 1)
    }

    /// Index of the first element for which `wanted` returns true.
    #[must_use]
    pub fn find(&self, wanted: impl FnMut(&T) -> bool) -> Option<I> {
        self.list.iter().position(wanted).map(I::new)
    }

    /// All indices, in order.
    pub fn places(&self) -> impl DoubleEndedIterator<Item = I> + ExactSizeIterator + use<I, T> {
        (0..self.list.len()).map(I::new)
    }

    /// All elements with their indices, in order.
    pub fn pairs(&self) -> impl DoubleEndedIterator<Item = (I, &T)> + ExactSizeIterator {
        self.list.iter().enumerate().map(|(index, element)| (I::new(index), element))
    }

    /// A list with the same indices, of elements made from these.
    #[must_use]
    pub fn map<U>(&self, mut make: impl FnMut(I, &T) -> U) -> Indexed<I, U> {
        self.pairs().map(|(ix, element)| make(ix, element)).collect()
    }
}

impl<I: Ix, T> Index<I> for Indexed<I, T> {
    type Output = T;

    #[inline]
    fn index(&self, ix: I) -> &T {
        &self.list[ix.index()]
    }
}

impl<I: Ix, T> IndexMut<I> for Indexed<I, T> {
    #[inline]
    fn index_mut(&mut self, ix: I) -> &mut T {
        &mut self.list[ix.index()]
    }
}

impl<I, T> Deref for Indexed<I, T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        &self.list
    }
}

impl<I, T> DerefMut for Indexed<I, T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.list
    }
}

impl<I, T> Default for Indexed<I, T> {
    fn default() -> Self {
        Self::from_iter([])
    }
}

impl<I, T: fmt::Debug> fmt::Debug for Indexed<I, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.list.fmt(f)
    }
}

impl<I, T> FromIterator<T> for Indexed<I, T> {
    fn from_iter<A: IntoIterator<Item = T>>(elements: A) -> Self {
        Self { list: elements.into_iter().collect(), place: PhantomData }
    }
}

impl<I, T> IntoIterator for Indexed<I, T> {
    type Item = T;
    type IntoIter = std::vec::IntoIter<T>;

    fn into_iter(self) -> Self::IntoIter {
        self.list.into_iter()
    }
}

impl<'a, I, T> IntoIterator for &'a Indexed<I, T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.list.iter()
    }
}

impl<'a, I, T> IntoIterator for &'a mut Indexed<I, T> {
    type Item = &'a mut T;
    type IntoIter = std::slice::IterMut<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.list.iter_mut()
    }
}
