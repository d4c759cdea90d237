//! Tiles that are prepared for moments. In: a query, a tile. Out: its irradiances. Prepared tiles
//! are kept as long as there is room, so that a sun that moves costs multiplications only.

use std::collections::HashMap;
use std::hint::black_box;

use heliotile_core::error::Result;
use heliotile_core::light::states::Schedule;
use heliotile_core::replay::interactive::{InteractiveLight, InteractiveReplay, InteractiveTile, TileTextures};
use heliotile_core::replay::values::TileValues;

use crate::asked::{MomentAsk, sky_of};
use crate::failure::{Failure, Kind};
use crate::light::Forced;
use crate::open::Opened;

/// Bytes of prepared tiles that all engines of an archive keep together.
const ROOM: usize = 360 << 20;

/// Step by which memory grows when tiles fill it, bytes. At each step the browser looks through all
/// that its script holds, so steps are few.
const STEP: usize = 8 << 20;

/// Number of tiles whose light is solved for together, if reflectances are changed.
const TOGETHER: usize = 4;

/// Number of states of the reflectances that are kept: the stored one, the one in use and the one
/// before.
const STATES: usize = 3;

/// Site in one state of its reflectances.
struct State {
    schedules: Vec<Schedule>,
    moments: InteractiveReplay<'static>,
    ready: HashMap<u32, Ready>,
}

/// Prepared tile, and the number of the query that used it last.
struct Ready {
    tile: InteractiveTile,
    turn: u64,
}

/// Light of the last query.
struct Lit {
    ask: MomentAsk,
    light: InteractiveLight,
}

/// Prepared tiles and light of moments.
#[derive(Default)]
pub struct InteractiveTiles {
    /// States of the reflectances, the one in use first.
    states: Vec<State>,
    lit: Option<Lit>,
    /// Number of the present query.
    turn: u64,
    bytes: usize,
    /// Number of engines that share the room; 0 counts as 1.
    engines: usize,
}

impl InteractiveTiles {
    /// Keeps tiles in a share of the room from now on: all of it divided by `engines`.
    pub fn share(&mut self, engines: usize) {
        self.engines = engines;
    }

    /// Forgets the light, since the weather or the clouds changed.
    pub fn clear(&mut self) {
        self.lit = None;
    }

    /// Returns the values of a tile. `force` makes the light if the query is a new one. `next`
    /// names tiles that the page will ask for, which are prepared together with this one where that
    /// is cheaper.
    pub fn values(
        &mut self,
        opened: &Opened,
        ask: &MomentAsk,
        tile: u32,
        next: &[u32],
        force: impl FnOnce() -> Result<Forced>,
    ) -> std::result::Result<TileValues, Failure> {
        let tile = opened.tile(tile)?;
        self.light(opened, ask, force)?;
        self.made(opened, tile, next, |lit, made| lit.map(|lit| made.irradiance(&lit.light)))?.ok_or_else(none)
    }

    /// Returns the result of `of` for a tile with these reflectances, for any light.
    pub fn textures<T>(
        &mut self,
        opened: &Opened,
        schedules: Vec<Schedule>,
        tile: u32,
        next: &[u32],
        of: impl Fn(Option<TileTextures<'_>>) -> T,
    ) -> std::result::Result<T, Failure> {
        let tile = opened.tile(tile)?;
        if self.states.first().is_none_or(|state| state.schedules != schedules) {
            self.lit = None;
            self.reflecting(opened, schedules)?;
        }
        self.made(opened, tile, next, |_, made| of(made.textures()))
    }

    /// Returns the result of `of` for a tile in the state in use, and prepares the tile if needed.
    fn made<T>(
        &mut self,
        opened: &Opened,
        tile: u32,
        next: &[u32],
        of: impl Fn(Option<&Lit>, &InteractiveTile) -> T,
    ) -> std::result::Result<T, Failure> {
        let state = self.states.first_mut().ok_or_else(none)?;
        if let Some(ready) = state.ready.get_mut(&tile) {
            ready.turn = self.turn;
            return Ok(of(self.lit.as_ref(), &ready.tile));
        }
        let missing = |other: &&u32| **other < opened.site.tiles() && !state.ready.contains_key(*other);
        let mut group: Vec<u32> = [&tile].into_iter().chain(next.iter().filter(missing)).copied().collect();
        state.moments.expect(&group);
        // Cells that several tiles see are read and solved once for all of them. If a block is
        // damaged, only the tile asked for may fail.
        group.truncate(if state.schedules.is_empty() { 1 } else { TOGETHER });
        let made = match state.moments.tiles(&group) {
            Err(_) if group.len() > 1 => {
                group.truncate(1);
                state.moments.tiles(&group)
            }
            made => made,
        }?;
        let found = made.first().map(|made| of(self.lit.as_ref(), made));
        for (tile, made) in group.into_iter().zip(made) {
            self.keep(tile, made);
        }
        found.ok_or_else(none)
    }

    /// Returns the light of a query, made if the query is a new one. The state of its reflectances
    /// is then the one in use.
    pub fn light(
        &mut self,
        opened: &Opened,
        ask: &MomentAsk,
        force: impl FnOnce() -> Result<Forced>,
    ) -> std::result::Result<&InteractiveLight, Failure> {
        if self.lit.as_ref().is_none_or(|lit| lit.ask != *ask) {
            let Forced { conditions, schedules, .. } = force()?;
            let sky = sky_of(&ask.sky)?;
            self.reflecting(opened, schedules)?;
            let of = self.states.first().zip(conditions.first());
            self.lit =
                of.map(|(state, condition)| Lit { ask: ask.clone(), light: state.moments.light(condition, sky) });
            self.turn += 1;
        }
        self.lit.as_ref().map(|lit| &lit.light).ok_or_else(none)
    }

    /// Puts a state of the reflectances in use.
    fn reflecting(&mut self, opened: &Opened, schedules: Vec<Schedule>) -> std::result::Result<(), Failure> {
        match self.states.iter().position(|state| state.schedules == schedules) {
            Some(place) => self.states[..=place].rotate_right(1),
            None => {
                let moments = match self.states.first() {
                    Some(state) => state.moments.reflecting(&schedules)?,
                    None => {
                        let patches = opened.archive.manifest().settings.patches();
                        InteractiveReplay::new(&opened.site, patches, &schedules)?
                    }
                };
                self.states.insert(0, State { schedules, moments, ready: HashMap::new() });
                for old in self.states.drain(STATES.min(self.states.len())..) {
                    self.bytes -= old.ready.values().map(|ready| ready.tile.bytes()).sum::<usize>();
                }
            }
        }
        Ok(())
    }

    /// Keeps a tile of the state in use if there is room, or if tiles not used of late can make
    /// room.
    fn keep(&mut self, tile: u32, made: InteractiveTile) {
        let bytes = made.bytes();
        while self.bytes + bytes > ROOM / self.engines.max(1) {
            let all = self
                .states
                .iter()
                .enumerate()
                .flat_map(|(place, state)| state.ready.iter().map(move |(tile, ready)| (ready.turn, place, *tile)));
            // Tiles of a query are asked for in turn, so its least recent tiles come next: tiles of
            // this query and of the one before stay.
            let Some((_, place, oldest)) = all.min().filter(|(turn, ..)| turn + 1 < self.turn) else { return };
            let gone = self.states[place].ready.remove(&oldest);
            self.bytes -= gone.map_or(0, |gone| gone.tile.bytes());
        }
        if let Some(state) = self.states.first_mut() {
            if self.bytes / STEP < (self.bytes + bytes) / STEP {
                grow();
            }
            self.bytes += bytes;
            let before = state.ready.insert(tile, Ready { tile: made, turn: self.turn });
            self.bytes -= before.map_or(0, |before| before.tile.bytes());
        }
    }
}

/// Makes memory grow by a step at once, if it can.
fn grow() {
    let mut room = Vec::<u8>::new();
    // If memory cannot grow, tiles ask for memory one by one.
    let _ = room.try_reserve(STEP);
    black_box(room);
}

fn none() -> Failure {
    Failure::new(Kind::Other, "there is no light", "")
}
