//! Where ports are: in this process, or in one of its cells, whose processes come and go.

use std::collections::BTreeMap;
use std::os::fd::OwnedFd;
use std::sync::Arc;

use genom_cells::{Cell, Cells};
use genom_doors::RpcError;
use genom_protocol::{CellState, Code};
use genom_supervisor::Supervisor;
use tokio::runtime::Handle;

use crate::far::{Far, Undone, is_closed};
use crate::memory::Memory;
use crate::open::{At, Open};
use crate::port::{Port, parse};
use crate::wire::Taken;

pub(crate) struct Places {
    pub(crate) supervisor: Arc<Supervisor>,
    cells: Arc<Cells>,
    runtime: Handle,
    /// Processes of cells, as of the last step, in the order in which they are stepped.
    far: Vec<Far>,
}

impl Places {
    pub(crate) fn new(supervisor: &Arc<Supervisor>, cells: &Arc<Cells>, runtime: Handle) -> Self {
        let (supervisor, cells) = (Arc::clone(supervisor), Arc::clone(cells));
        Self { supervisor, cells, runtime, far: Vec::new() }
    }

    /// Opens the port at an address.
    pub(crate) fn open(&mut self, text: &str) -> Result<Open, RpcError> {
        let address = parse(text)?;
        let Some(cell) = self.cells.of(&address.component) else {
            let mut port = Port::find(&self.supervisor, text)?;
            let memory = port.memory(&self.supervisor)?;
            return Ok(Open::here(address, port, memory));
        };
        let Some(socket) = self.running(&cell)? else {
            return Err(self.down(&cell));
        };
        let far = self.far(&cell, &socket);
        match far.open(&address) {
            Ok((found, memory)) => Ok(Open::there(address, found, &socket, memory)),
            Err(undone) => Err(self.told(&cell, undone)),
        }
    }

    /// Goes on with the memory of a port that another process had.
    pub(crate) fn take(&self, taken: &Taken<'_>, file: OwnedFd) -> Result<Open, RpcError> {
        let address = parse(taken.address)?;
        let port = Port::find(&self.supervisor, taken.address)?;
        let memory = Memory::of(file, port.ty().size())
            .map_err(|error| RpcError::bad_input(format!("{address}: {error}")))?;
        if (port.is_in(), port.ty().digest()) != (taken.is_in, taken.digest) {
            let message = format!("{address} has another type, or direction, than this memory");
            return Err(RpcError::conflict(Code::TypeMismatch, message));
        }
        let mut open = Open::here(address, port, memory).published(taken.published);
        open.show(&self.supervisor)?;
        Ok(open)
    }

    /// Forgets a port.
    pub(crate) fn close(&mut self, open: &Open) {
        if let At::There(socket, number) = &open.at
            && let Some(far) = self.far.iter_mut().find(|far| far.is(socket))
        {
            far.close(*number);
        }
    }

    /// Waits for cells that are to come back, and finds ports whose process is another one now.
    pub(crate) fn settle(&mut self, ports: &mut BTreeMap<u32, Open>) -> Result<(), RpcError> {
        let cells = self.cells.all();
        if cells.is_empty() && self.far.is_empty() && !ports.values().any(Open::is_gone) {
            return Ok(());
        }
        let mut running = Vec::new();
        for cell in &cells {
            running.extend(self.running(cell)?.map(|socket| (cell, socket)));
        }
        self.far.retain(|far| running.iter().any(|(_, socket)| far.is(socket)));
        for (cell, socket) in &running {
            self.far(cell, socket);
        }
        self.far.sort_by(|one, other| one.name.cmp(&other.name));
        for open in ports.values_mut() {
            if self.is_elsewhere(open) {
                self.find(open)?;
            }
        }
        Ok(())
    }

    /// Has cells publish what was written to their in ports.
    pub(crate) fn publish(&mut self, ports: &BTreeMap<u32, Open>) -> Result<(), RpcError> {
        if self.far.is_empty() {
            return Ok(());
        }
        let mut written: Vec<&Arc<OwnedFd>> = Vec::new();
        for open in ports.values() {
            if let At::There(socket, _) = &open.at
                && !written.iter().any(|one| Arc::ptr_eq(one, socket))
                && open.written()?.is_some()
            {
                written.push(socket);
            }
        }
        self.each(|far| match written.iter().any(|socket| far.is(socket)) {
            true => far.publish(),
            false => Ok(()),
        })
    }

    /// Steps all cells, one after the other.
    pub(crate) fn step(&mut self, nanoseconds: u64) -> Result<(), RpcError> {
        self.each(|far| far.step(nanoseconds))
    }

    fn each(&mut self, work: impl Fn(&mut Far) -> Result<(), Undone>) -> Result<(), RpcError> {
        let undone = self.far.iter_mut().find_map(|far| {
            let undone = work(far).err()?;
            Some((far.name.clone(), undone))
        });
        match undone {
            None => Ok(()),
            Some((_, Undone::Refused(error))) => Err(error),
            Some((name, Undone::Lost)) => Err(match self.cells.get(&name) {
                Some(cell) => self.down(&cell),
                None => RpcError::conflict(Code::CellDown, format!("cell {name} has ended")),
            }),
        }
    }

    /// The socket of a cell that runs, which is waited for if it is to come back. None of one that is
    /// down until somebody asks for it.
    fn running(&self, cell: &Cell) -> Result<Option<Arc<OwnedFd>>, RpcError> {
        loop {
            match cell.state() {
                CellState::Failed | CellState::Stopping => return Ok(None),
                CellState::Starting | CellState::Waiting => {
                    // What it is then is looked at next.
                    let _ = self.runtime.block_on(cell.begun());
                }
                CellState::Running => match cell.steps() {
                    Some(socket) if !is_closed(&socket) => return Ok(Some(socket)),
                    _ => {
                        let down = self.runtime.block_on(cell.lost());
                        if down.state == CellState::Running {
                            let message = format!(
                                "cell {} is not stepped: a daemon before this one started it",
                                cell.name()
                            );
                            return Err(RpcError::conflict(Code::CellDown, message)
                                .help(format!("`genomctl cells --restart {}`", cell.name())));
                        }
                    }
                },
            }
        }
    }

    /// What this process knows of one of a cell.
    fn far(&mut self, cell: &Cell, socket: &Arc<OwnedFd>) -> &mut Far {
        let place = self.far.iter().position(|far| far.is(socket)).unwrap_or_else(|| {
            self.far.push(Far::new(cell.name(), Arc::clone(socket)));
            self.far.len() - 1
        });
        &mut self.far[place]
    }

    /// Whether a port is not where it was.
    fn is_elsewhere(&self, open: &Open) -> bool {
        match &open.at {
            At::Here(port) => port.is_gone(),
            At::Nowhere => true,
            At::There(socket, _) => match self.far.iter().find(|far| far.is(socket)) {
                None => true,
                Some(far) => far.gone > 0 && open.memory.is_gone().unwrap_or(true),
            },
        }
    }

    /// Finds a port in the process where its component is now.
    fn find(&mut self, open: &mut Open) -> Result<(), RpcError> {
        let text = open.address.to_string();
        let here = Port::find(&self.supervisor, &text).ok();
        let here =
            here.filter(|port| open.is_like(port.is_in(), port.ty().size(), port.ty().digest()));
        if let Some(port) = here {
            self.close(open);
            return open.goes_to(At::Here(port));
        }
        let cell = self.cells.of(&open.address.component);
        let place = cell.and_then(|cell| self.far.iter().position(|far| far.name == cell.name()));
        let Some(far) = place.map(|place| &mut self.far[place]) else {
            self.close(open);
            return open.goes_to(At::Nowhere);
        };
        if matches!(&open.at, At::There(socket, _) if far.is(socket)) {
            // It is looked for there.
            return Ok(());
        }
        let at = match far.take(&open.taken(&text), &open.memory) {
            Ok(found) if open.is_like(found.is_in, found.size, &found.digest) => {
                At::There(Arc::clone(far.socket()), found.number)
            }
            Ok(found) => {
                far.close(found.number);
                At::Nowhere
            }
            // One that is lost is told when it is stepped.
            Err(_) => At::Nowhere,
        };
        self.close(open);
        open.goes_to(at)
    }

    fn told(&self, cell: &Cell, undone: Undone) -> RpcError {
        match undone {
            Undone::Refused(error) => error,
            Undone::Lost => self.down(cell),
        }
    }

    /// Why a cell cannot be asked.
    fn down(&self, cell: &Cell) -> RpcError {
        let down = self.runtime.block_on(cell.lost());
        let message = match down.state {
            CellState::Running => format!("cell {} does not answer as it should", cell.name()),
            _ => down.to_string(),
        };
        RpcError::conflict(Code::CellDown, message)
    }
}
