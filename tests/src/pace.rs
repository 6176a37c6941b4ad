//! How fast pages of the web console are, as the browser measures it.

use serde_json::{Value, json};

use crate::browser::Browser;

/// What a browser loaded for a page, and when the page had its first values.
#[derive(Clone, Debug)]
pub struct Load {
    /// Files and replies.
    pub requests: u64,
    /// Their size with heads, in bytes, but for the live stream.
    pub bytes: u64,
    /// Milliseconds from asking for the address until the page was complete and could be used.
    pub milliseconds: f64,
}

/// Frames of a page over some seconds.
#[derive(Clone, Copy, Debug)]
pub struct Frames {
    /// In a second.
    pub rate: f64,
    /// Median time between two, in milliseconds.
    pub median: f64,
    /// 95 of 100 were not longer apart, in milliseconds.
    pub most: f64,
}

/// What happens while frames are counted.
#[derive(Clone, Copy, Debug)]
pub enum Hand {
    /// Only values change.
    Still,
    /// The drawing is dragged to and fro.
    Pans,
    /// The wheel zooms in and out.
    Zooms,
    /// The pointer passes over components, whose connections light up.
    Points,
}

/// Opens a page that nothing of was loaded before, and waits until it has its values.
///
/// # Panics
/// If they do not come.
#[must_use]
#[track_caller]
pub fn load(browser: &Browser, address: &str) -> Load {
    browser.open(address);
    browser
        .until("the page has values", "performance.getEntriesByName('shown', 'mark').length > 0");
    let told = browser.ask(
        "const all = [...performance.getEntriesByType('navigation'),
           ...performance.getEntriesByType('resource')].filter((one) => !one.name.includes('/live?'));
         return [all.length, all.reduce((sum, one) => sum + one.transferSize, 0),
           performance.getEntriesByName('shown', 'mark')[0].startTime]",
    );
    let number = |at: usize| told[at].as_f64().expect("a number");
    let count = |at: usize| told[at].as_u64().expect("a count");
    Load { requests: count(0), bytes: count(1), milliseconds: number(2) }
}

/// Counts frames of the graph for 5 s.
///
/// # Panics
/// If it is not shown.
#[must_use]
#[track_caller]
pub fn frames(browser: &Browser, hand: Hand) -> Frames {
    let hand = format!("{hand:?}");
    browser.with(COUNT, vec![json!(hand)]);
    browser.until("frames are counted", "window.counted");
    let times: Value = browser.ask("return window.counted");
    let number = |at: usize| times[at].as_f64().expect("a number");
    Frames { rate: number(0), median: number(1), most: number(2) }
}

/// Moves as a hand does, once in each frame.
const COUNT: &str = "
  const graph = document.getElementById('graph');
  const box = graph.getBoundingClientRect();
  const middle = { clientX: box.x + box.width / 2, clientY: box.y + box.height / 2, bubbles: true, cancelable: true };
  const pointer = (kind, more) => new PointerEvent(kind, { ...middle, button: 0, pointerId: 1, ...more });
  const nodes = graph.querySelectorAll('[data-id]');
  const acts = {
    Still: () => {},
    Pans: (n) => dispatchEvent(pointer('pointermove', { clientX: middle.clientX + 200 * Math.sin(n / 15), clientY: middle.clientY + 100 * Math.sin(n / 11) })),
    Zooms: (n) => graph.dispatchEvent(new WheelEvent('wheel', { ...middle, deltaY: n % 60 < 30 ? -30 : 30 })),
    Points: (n) => nodes[n % nodes.length].dispatchEvent(pointer('pointerover')),
  };
  const hand = arguments[0];
  window.counted = null;
  if (hand === 'Pans') graph.dispatchEvent(pointer('pointerdown'));
  const times = [];
  const step = (now) => {
    times.push(now);
    acts[hand](times.length);
    if (now - times[0] < 5000) return requestAnimationFrame(step);
    dispatchEvent(pointer('pointerup'));
    const apart = times.slice(1).map((time, at) => time - times[at]).sort((one, other) => one - other);
    window.counted = [apart.length * 1000 / (times.at(-1) - times[0]), apart[apart.length >> 1], apart[Math.floor(apart.length * 0.95)]];
  };
  requestAnimationFrame(step);
";
