//! States that lead to each other.

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
