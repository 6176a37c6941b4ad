//! Which of some things cost most together, if not each may be beside each other one.

/// Things that are looked at in all combinations; of more, all count.
const MOST: usize = 20;

/// The dearest things that there can be together: pairs of a number and its cost, as many as there are
/// slots at most. Of those that may be beside themselves there are as many as instances.
pub fn dearest(
    costs: &[(u16, u64)],
    (slots, instances): (usize, usize),
    together: &dyn Fn(u16, u16) -> bool,
) -> Vec<(u16, u64)> {
    let mut all: Vec<(u16, u64)> = Vec::new();
    for &(one, cost) in costs {
        let count = if together(one, one) { instances } else { 1 };
        all.extend(std::iter::repeat_n((one, cost), count.min(slots)));
    }
    all.sort_by_key(|(_, cost)| std::cmp::Reverse(*cost));
    if all.len() > MOST {
        all.truncate(slots);
        return all;
    }
    let mut best = (0, Vec::new());
    choose((slots, together), &all, &mut Vec::new(), 0, &mut best);
    best.1
}

fn choose(
    (slots, together): (usize, &dyn Fn(u16, u16) -> bool),
    left: &[(u16, u64)],
    chosen: &mut Vec<(u16, u64)>,
    cost: u64,
    best: &mut (u64, Vec<(u16, u64)>),
) {
    if cost > best.0 {
        *best = (cost, chosen.clone());
    }
    let rest: u64 = left.iter().map(|(_, cost)| *cost).fold(0, u64::saturating_add);
    let full = chosen.len() >= slots;
    let Some(((one, own), after)) = left.split_first() else { return };
    if full || cost.saturating_add(rest) <= best.0 {
        return;
    }
    if chosen.iter().all(|(other, _)| together(*one, *other)) {
        chosen.push((*one, *own));
        choose((slots, together), after, chosen, cost.saturating_add(*own), best);
        chosen.pop();
    }
    choose((slots, together), after, chosen, cost, best);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dearest_ones_are_those_that_may_be_together() {
        let costs = [(0, 5), (1, 4), (2, 3)];
        // The first one is alone, also of its kind.
        let apart = |a: u16, b: u16| a != 0 && b != 0;
        assert_eq!(dearest(&costs, (2, 1), &apart), [(1, 4), (2, 3)]);
        assert_eq!(dearest(&costs, (2, 2), &apart), [(1, 4), (1, 4)]);
        assert_eq!(dearest(&costs, (1, 2), &apart), [(0, 5)]);
    }
}
