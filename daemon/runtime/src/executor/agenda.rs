//! What the shared thread has to do, by date and by deadline.
//!
//! A pass of a task, and a turn of control work, are never interrupted by another one: between two
//! of them the one with the earliest deadline is next. A pass allocates nothing and takes no lock:
//! room for all tasks is made when they arrive.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::link::{Link, Mail};
use super::member::{Member, Turn};
use crate::clock::monotonic;
use crate::shared::Shared;
use crate::task::call::Call;
use crate::task::rhythm::{Next, Rhythm};
use crate::task::runner::Runner;

/// Something to do for an instance. The order of fields matters: of two with one deadline the
/// instance that was started first precedes, then its tasks in order of declaration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Due {
    /// When it begins to be due, or its deadline once it is.
    date: u64,
    seat: u64,
    what: What,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum What {
    /// A pass of the task with this index.
    Task(usize),
    Control,
}

/// An instance.
struct Seat {
    number: u64,
    member: Arc<dyn Member>,
    shared: Arc<Shared>,
    call: Arc<Call>,
    tasks: Vec<Seated>,
    /// Control work is in `ready`.
    ready: bool,
    /// The date in `dates` at which control has something to do.
    wakes: Option<u64>,
}

/// A task.
struct Seated {
    runner: Runner,
    rhythm: Rhythm,
    /// The deadline of its pass in `ready`; one with another deadline was replaced.
    ready: Option<u64>,
    /// The tick in `dates` that it waits for.
    tick: Option<u64>,
}

/// What there is to do.
pub(crate) struct Agenda {
    link: Arc<Link>,
    /// In order of their numbers.
    seats: Vec<Seat>,
    /// What becomes due at a date.
    dates: BinaryHeap<Reverse<Due>>,
    /// What is due, by deadline.
    ready: BinaryHeap<Reverse<Due>>,
}

impl Agenda {
    pub(crate) fn new(link: Arc<Link>) -> Self {
        Self { link, seats: Vec::new(), dates: BinaryHeap::new(), ready: BinaryHeap::new() }
    }

    /// Runs until the executor is dropped and all instances have stopped.
    pub(crate) fn run(mut self) {
        let bell = Arc::clone(&self.link.bell);
        let mut rung = true;
        loop {
            let rounds = &self.link.rounds;
            rounds.store(rounds.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
            if rung {
                self.link.take_mail().into_iter().for_each(|mail| self.admit(mail));
                self.look();
            }
            self.release(monotonic());
            if let Some(Reverse(due)) = self.ready.pop() {
                self.execute(due);
                rung = bell.take();
            } else if self.link.is_closed() && self.seats.is_empty() {
                return;
            } else {
                let next = self.dates.peek().map_or(u64::MAX, |Reverse(due)| due.date);
                rung = bell.sleep_until(next);
            }
        }
    }

    /// An instance or a task arrives.
    fn admit(&mut self, mail: Mail) {
        match mail {
            Mail::Member { seat: number, member, shared, call } => {
                let (tasks, ready, wakes) = (Vec::new(), false, None);
                self.seats.push(Seat { number, member, shared, call, tasks, ready, wakes });
                // Numbers are drawn before they are sent, so that two may arrive in another order.
                self.seats.sort_by_key(|seat| seat.number);
                self.control_is_due(number, monotonic());
            }
            Mail::Task { seat: number, runner } => {
                let Some(at) = self.seat(number) else { return };
                let (seat, now) = (&mut self.seats[at], monotonic());
                let me = &seat.shared.tasks[runner.task()];
                me.set_thread_number();
                let rhythm = Rhythm::new(me, now);
                let date = rhythm.deadline(now);
                let what = What::Task(seat.tasks.len());
                seat.tasks.push(Seated { runner, rhythm, ready: Some(date), tick: None });
                self.make_room();
                self.ready.push(Reverse(Due { date, seat: number, what }));
            }
        }
    }

    /// Makes room for everything that tasks and control can have to do at once.
    fn make_room(&mut self) {
        // A task is in one heap, and once more in `dates` if it was hurried before its tick, which
        // happens at most three times, when it stops. Control has a few dates.
        let tasks: usize = self.seats.iter().map(|seat| seat.tasks.len()).sum();
        let room = tasks * 4 + self.seats.len() * 8;
        for heap in [&mut self.dates, &mut self.ready] {
            heap.reserve(room.saturating_sub(heap.len()));
        }
    }

    fn seat(&self, number: u64) -> Option<usize> {
        self.seats.binary_search_by_key(&number, |seat| seat.number).ok()
    }

    /// Looks at the instances for which somebody rang.
    fn look(&mut self) {
        let now = monotonic();
        for seat in &mut self.seats {
            if !seat.call.take() {
                continue;
            }
            for (rank, task) in seat.tasks.iter_mut().enumerate() {
                let me = &seat.shared.tasks[task.runner.task()];
                let date = match task.rhythm {
                    // It waits for its tick, or its tick for others.
                    Rhythm::Periodic { .. }
                        if task.ready.is_none_or(|date| date > now) && me.hurry.take() =>
                    {
                        now
                    }
                    Rhythm::Aperiodic { .. } if task.ready.is_none() && me.is_runnable() => {
                        seat.shared.respond_by(now)
                    }
                    _ => continue,
                };
                (task.tick, task.ready) = (None, Some(date));
                self.ready.push(Reverse(Due { date, seat: seat.number, what: What::Task(rank) }));
            }
            if !std::mem::replace(&mut seat.ready, true) {
                let (date, seat) = (seat.shared.respond_by(now), seat.number);
                self.ready.push(Reverse(Due { date, seat, what: What::Control }));
            }
        }
    }

    /// Moves what has become due to `ready`, with its deadline.
    fn release(&mut self, now: u64) {
        while let Some(&Reverse(due)) = self.dates.peek()
            && due.date <= now
        {
            self.dates.pop();
            let Some(at) = self.seat(due.seat) else { continue };
            let seat = &mut self.seats[at];
            match due.what {
                What::Task(rank) => {
                    let task = &mut seat.tasks[rank];
                    // Otherwise it was hurried meanwhile.
                    if task.tick == Some(due.date) {
                        let date = task.rhythm.deadline(due.date);
                        (task.tick, task.ready) = (None, Some(date));
                        self.ready.push(Reverse(Due { date, ..due }));
                    }
                }
                What::Control if seat.wakes == Some(due.date) => {
                    seat.wakes = None;
                    self.control_is_due(due.seat, now);
                }
                What::Control => {}
            }
        }
    }

    fn control_is_due(&mut self, number: u64, now: u64) {
        let Some(at) = self.seat(number) else { return };
        if !std::mem::replace(&mut self.seats[at].ready, true) {
            let date = self.seats[at].shared.respond_by(now);
            let due = Due { date, seat: number, what: What::Control };
            self.ready.push(Reverse(due));
        }
    }

    fn execute(&mut self, due: Due) {
        let Some(at) = self.seat(due.seat) else { return };
        match due.what {
            What::Task(rank) => self.pass(at, rank, due),
            What::Control => self.control(at),
        }
    }

    fn pass(&mut self, at: usize, rank: usize, due: Due) {
        let seat = &mut self.seats[at];
        let task = &mut seat.tasks[rank];
        let me = &seat.shared.tasks[task.runner.task()];
        if task.ready != Some(due.date) {
            // It was hurried, and is done already or comes next.
            return;
        }
        task.ready = None;
        if me.quits() {
            return;
        }
        let next = task.rhythm.pass(&mut task.runner, me, monotonic());
        let (date, ready) = match next {
            Next::Called => return,
            Next::Now(end) => (task.rhythm.deadline(end), true),
            // Hurried while it was at work.
            Next::At(_) if me.hurry.take() => (task.rhythm.deadline(monotonic()), true),
            Next::At(date) => (date, false),
        };
        (task.ready, task.tick) = if ready { (Some(date), None) } else { (None, Some(date)) };
        let heap = if ready { &mut self.ready } else { &mut self.dates };
        heap.push(Reverse(Due { date, ..due }));
    }

    fn control(&mut self, at: usize) {
        let seat = &mut self.seats[at];
        let number = seat.number;
        seat.ready = false;
        match Arc::clone(&seat.member).turn() {
            Turn::More => self.control_is_due(number, monotonic()),
            // An earlier date is kept: what is to do then says the next one.
            Turn::At(date) if seat.wakes.is_none_or(|wakes| wakes > date) => {
                seat.wakes = Some(date);
                self.dates.push(Reverse(Due { date, seat: number, what: What::Control }));
            }
            Turn::At(_) | Turn::Idle => {}
            Turn::Over => self.leave(at),
        }
    }

    /// Releases an instance that has stopped: its memory and code first, then whoever waits.
    fn leave(&mut self, at: usize) {
        let Seat { number, member, shared, call, tasks, .. } = self.seats.remove(at);
        let now = monotonic();
        for Seated { runner, rhythm, .. } in tasks {
            rhythm.ends(&shared.tasks[runner.task()], now);
        }
        drop(shared);
        for heap in [&mut self.dates, &mut self.ready] {
            heap.retain(|Reverse(due)| due.seat != number);
        }
        self.link.leave(number);
        member.left();
        drop(member);
        call.gone();
    }
}
