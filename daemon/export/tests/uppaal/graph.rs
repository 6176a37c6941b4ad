//! States with what is seen of them, and the steps between them.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

/// All states that can be reached; the first one is where it begins.
#[derive(Debug, Default)]
pub(crate) struct Graph {
    /// What is seen of each state.
    pub(crate) seen: Vec<Vec<i32>>,
    /// What its steps lead to.
    pub(crate) steps: Vec<Vec<usize>>,
}

/// What two graphs have in common if one is the other with other names.
pub(crate) type Shape = (usize, usize, Vec<u64>);

/// What is seen in as many steps from each state is compared.
const DEPTH: usize = 12;

impl Graph {
    /// Of states and steps how many there are, and from each state what can be seen after it: as numbers,
    /// which differ if that does, that of the first state, then those of all in order.
    pub(crate) fn shape(&self) -> Shape {
        let hash = |of: &dyn Fn(&mut DefaultHasher)| {
            let mut hasher = DefaultHasher::new();
            of(&mut hasher);
            hasher.finish()
        };
        let mut all: Vec<u64> =
            self.seen.iter().map(|seen| hash(&|into| seen.hash(into))).collect();
        for _ in 0..DEPTH {
            let after = |steps: &Vec<usize>| {
                let mut after: Vec<u64> = steps.iter().map(|to| all[*to]).collect();
                after.sort_unstable();
                after
            };
            let own = self.steps.iter().zip(&all);
            all = own.map(|(steps, own)| hash(&|into| (own, after(steps)).hash(into))).collect();
        }
        let first = all[0];
        all.sort_unstable();
        all.insert(0, first);
        (self.steps.len(), self.steps.iter().map(Vec::len).sum(), all)
    }
}

/// Builds a graph from a state and what follows each; `None` if it has more states than that.
pub(crate) fn reached<S: Clone + Eq + Hash>(
    first: S,
    most: usize,
    mut look: impl FnMut(&S, &mut Vec<S>) -> Vec<i32>,
) -> Option<Graph> {
    let mut places: HashMap<S, usize> = HashMap::from([(first.clone(), 0)]);
    let (mut states, mut graph, mut next) = (vec![first], Graph::default(), Vec::new());
    while let Some(state) = states.get(graph.seen.len()).cloned() {
        graph.seen.push(look(&state, &mut next));
        let mut steps = Vec::with_capacity(next.len());
        for state in next.drain(..) {
            let new = states.len();
            let at = *places.entry(state).or_insert_with_key(|state| {
                states.push(state.clone());
                new
            });
            steps.push(at);
        }
        graph.steps.push(steps);
        if states.len() > most {
            return None;
        }
    }
    Some(graph)
}
