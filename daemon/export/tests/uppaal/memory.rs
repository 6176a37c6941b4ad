//! Values of variables, and what expressions and functions make of them.

use super::code::{Expr, Function, Operator, Place, Space, Statement, Type};

/// What does not change.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fixed {
    pub(crate) constants: Vec<i32>,
    pub(crate) functions: Vec<Function>,
    /// The range of each global number.
    pub(crate) ranges: Vec<(i32, i32)>,
}

/// Variables and clocks of a state.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Values {
    pub(crate) numbers: Vec<i32>,
    pub(crate) clocks: Vec<i32>,
}

/// A state in which something is evaluated.
pub(crate) struct Machine<'m> {
    pub(crate) fixed: &'m Fixed,
    pub(crate) values: &'m mut Values,
    /// Parameters and variables of the functions that are called.
    pub(crate) stack: Vec<i32>,
    /// Where those of the last one begin.
    pub(crate) frame: usize,
    pub(crate) is_deadlock: bool,
}

/// How a statement ended.
enum Flow {
    On,
    Returned(i32),
}

impl<'m> Machine<'m> {
    pub(crate) fn new(fixed: &'m Fixed, values: &'m mut Values) -> Self {
        Self { fixed, values, stack: Vec::new(), frame: 0, is_deadlock: false }
    }

    pub(crate) fn holds(&mut self, expr: &Expr) -> bool {
        self.value(expr) != 0
    }

    fn offset(&mut self, place: &Place) -> usize {
        let mut at = place.base;
        for (index, size, count) in &place.indices {
            let index = self.value(index);
            let within = usize::try_from(index).ok().filter(|index| index < count);
            at += within.unwrap_or_else(|| panic!("index {index} of {count}")) * size;
        }
        at
    }

    fn store(&mut self, place: &Place, value: i32) {
        let at = self.offset(place);
        let Some((least, most)) = place.of.range() else {
            assert_eq!((place.space, &place.of), (Space::Clock, &Type::Clock), "{place:?}");
            assert!(value >= 0, "a clock is {value}");
            self.values.clocks[at] = value;
            return;
        };
        assert!(
            (least..=most).contains(&value),
            "{value} is not from {least} to {most}: {place:?}"
        );
        match place.space {
            Space::Global => self.values.numbers[at] = value,
            Space::Local => self.stack[self.frame + at] = value,
            Space::Constant | Space::Clock => panic!("{place:?} is assigned"),
        }
    }

    fn load(&mut self, place: &Place) -> i32 {
        let at = self.offset(place);
        match place.space {
            Space::Constant => self.fixed.constants[at],
            Space::Global => self.values.numbers[at],
            Space::Local => self.stack[self.frame + at],
            Space::Clock => self.values.clocks[at],
        }
    }

    pub(crate) fn value(&mut self, expr: &Expr) -> i32 {
        match expr {
            Expr::Number(number) => *number,
            Expr::Load(place) => self.load(place),
            Expr::Not(of) => i32::from(self.value(of) == 0),
            Expr::Two(operator, a, b) => {
                // Both are valid, whether UPPAAL looks at the second one or not.
                let (a, b) = (self.value(a), self.value(b));
                match operator {
                    Operator::And => i32::from(a != 0 && b != 0),
                    Operator::Or => i32::from(a != 0 || b != 0),
                    Operator::Equal => i32::from(a == b),
                    Operator::Differ => i32::from(a != b),
                    Operator::Less => i32::from(a < b),
                    Operator::AtMost => i32::from(a <= b),
                    Operator::AtLeast => i32::from(a >= b),
                    Operator::Greater => i32::from(a > b),
                    Operator::Plus => a + b,
                    Operator::Minus => a - b,
                    Operator::Times => a * b,
                }
            }
            Expr::Assign(place, of) => {
                let value = self.value(of);
                self.store(place, value);
                value
            }
            Expr::Step(place, by) => {
                let value = self.load(place);
                self.store(place, value + by);
                value
            }
            Expr::Copy(to, from) => {
                let (to_at, from_at, size) = (self.offset(to), self.offset(from), to.of.size());
                self.values.numbers.copy_within(from_at..from_at + size, to_at);
                0
            }
            Expr::Call(function, given) => self.call(*function, given),
            Expr::Deadlock => i32::from(self.is_deadlock),
        }
    }

    fn call(&mut self, function: usize, given: &[Expr]) -> i32 {
        let function = &self.fixed.functions[function];
        let given: Vec<i32> = given.iter().map(|one| self.value(one)).collect();
        for (value, (least, most)) in given.iter().zip(&function.takes) {
            assert!((least..=most).contains(&value), "{} is given {value}", function.name);
        }
        let (frame, top) = (self.frame, self.stack.len());
        self.frame = top;
        self.stack.extend(given);
        self.stack.resize(top + function.frame, 0);
        let flow = self.run(&function.body);
        self.stack.truncate(top);
        self.frame = frame;
        match (flow, function.gives.range()) {
            (Flow::Returned(value), Some((least, most))) => {
                assert!((least..=most).contains(&value), "{} gives {value}", function.name);
                value
            }
            (_, None) => 0,
            _ => panic!("{} gives nothing", function.name),
        }
    }

    fn run(&mut self, statement: &Statement) -> Flow {
        match statement {
            Statement::Do(expr) => {
                self.value(expr);
            }
            Statement::If(condition, then, otherwise) => {
                if self.holds(condition) {
                    return self.run(then);
                } else if let Some(otherwise) = otherwise {
                    return self.run(otherwise);
                }
            }
            Statement::While(condition, body) => {
                while self.holds(condition) {
                    if let Flow::Returned(value) = self.run(body) {
                        return Flow::Returned(value);
                    }
                }
            }
            Statement::For(head, body) => {
                let [first, condition, step] = &**head;
                self.value(first);
                while self.holds(condition) {
                    if let Flow::Returned(value) = self.run(body) {
                        return Flow::Returned(value);
                    }
                    self.value(step);
                }
            }
            Statement::Return(value) => {
                return Flow::Returned(value.as_ref().map_or(0, |value| self.value(value)));
            }
            Statement::All(statements) => {
                for statement in statements {
                    if let Flow::Returned(value) = self.run(statement) {
                        return Flow::Returned(value);
                    }
                }
            }
        }
        Flow::On
    }
}
