//! Nodes of a graph that can be reached from each other (Tarjan: Depth-First Search and Linear Graph
//! Algorithms, 1972).

/// What is not known yet.
const NONE: u32 = u32::MAX;

/// For each node that can be reached from `roots`, the number of its circle: the nodes that lead to
/// each other. Numbers begin at 0; other nodes have none.
#[must_use]
pub fn circles<I: Iterator<Item = u32>>(
    count: usize,
    roots: &[u32],
    next: impl Fn(u32) -> I,
) -> Vec<u32> {
    let mut circle = vec![NONE; count];
    // When a node was found, and the earliest one on the stack that it leads to.
    let (mut found, mut low) = (vec![NONE; count], vec![NONE; count]);
    let (mut stack, mut time, mut circles) = (Vec::new(), 0, 0);
    for root in roots {
        if found[*root as usize] != NONE {
            continue;
        }
        let mut open = vec![(*root, None::<I>)];
        while let Some((node, rest)) = open.last_mut() {
            let at = *node as usize;
            let rest = match rest {
                Some(rest) => rest,
                None => {
                    (found[at], low[at]) = (time, time);
                    time += 1;
                    stack.push(*node);
                    rest.insert(next(*node))
                }
            };
            match rest.next() {
                Some(to) if found[to as usize] == NONE => open.push((to, None)),
                // Of a circle that is complete nothing leads back.
                Some(to) if circle[to as usize] == NONE => {
                    low[at] = low[at].min(found[to as usize]);
                }
                Some(_) => {}
                None => {
                    open.pop();
                    if let Some((before, _)) = open.last() {
                        let before = *before as usize;
                        low[before] = low[before].min(low[at]);
                    }
                    if low[at] == found[at] {
                        while let Some(member) = stack.pop() {
                            circle[member as usize] = circles;
                            if member as usize == at {
                                break;
                            }
                        }
                        circles += 1;
                    }
                }
            }
        }
    }
    circle
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_that_lead_to_each_other_are_one_circle() {
        let edges: [&[u32]; 7] = [&[1], &[2, 3], &[0], &[4], &[5], &[4], &[6]];
        let next = |node: u32| edges[node as usize].iter().copied();
        let found = circles(7, &[0], next);
        assert_eq!(found[0], found[1]);
        assert_eq!(found[0], found[2]);
        assert_eq!(found[4], found[5]);
        assert_ne!(found[3], found[0]);
        assert_ne!(found[3], found[4]);
        assert_eq!(found[6], NONE, "it is not reached");
    }
}
