//! Nested bodies: which medium is where, decided by priority (`schmidt2002`).
//!
//! A liquid modelled as reaching a little into its glass leaves no gap and no doubled surface: where two bodies
//! overlap, the one of higher priority is there, and a surface of the lower one inside the higher is no surface.

/// The bodies a point lies in, by index, and the rule at their surfaces. Small: at most eight bodies overlap.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Interior {
    inside: [u16; Self::DEPTH],
    len: u8,
}

/// What a ray does at the surface of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Crossing {
    /// The surface is hidden inside a body of higher priority: go on straight, with the new interior.
    Hidden(Interior),
    /// A true interface: the interior beyond it, entered by refraction.
    Interface(Interior),
    /// Entering a body one is in, leaving one that one is not in, or too many bodies: a slip at an edge, to be
    /// counted and ignored.
    Inconsistent,
}

impl Interior {
    /// How many bodies may overlap in one point.
    pub const DEPTH: usize = 8;

    /// Whether the point lies in no body.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The bodies, in the order in which they were entered.
    pub fn bodies(&self) -> &[u16] {
        &self.inside[..usize::from(self.len)]
    }

    /// The body whose medium fills the point: the one of highest priority, the lower index among equals; `None`
    /// outside all. `priority` gives the priority of a body.
    #[inline]
    pub fn top(&self, priority: impl Fn(u16) -> i32) -> Option<u16> {
        self.bodies().iter().copied().max_by_key(|&body| (priority(body), std::cmp::Reverse(body)))
    }

    /// The rule at the surface of `body`, met from outside it (`entering`) or from inside.
    #[inline]
    pub fn cross(&self, body: u16, entering: bool, priority: impl Fn(u16) -> i32 + Copy) -> Crossing {
        let beyond = if entering { self.with(body) } else { self.without(body) };
        match beyond {
            None => Crossing::Inconsistent,
            Some(next) if next.top(priority) == self.top(priority) => Crossing::Hidden(next),
            Some(next) => Crossing::Interface(next),
        }
    }

    /// This interior and one more body; `None` if it is there already or there is no room.
    pub fn with(&self, body: u16) -> Option<Self> {
        if self.bodies().contains(&body) || usize::from(self.len) == Self::DEPTH {
            return None;
        }
        let mut next = *self;
        next.inside[usize::from(self.len)] = body;
        next.len += 1;
        Some(next)
    }

    /// This interior without a body; `None` if it is not there.
    pub fn without(&self, body: u16) -> Option<Self> {
        let at = self.bodies().iter().position(|&b| b == body)?;
        let mut next = *self;
        next.inside.copy_within(at + 1..usize::from(self.len), at);
        next.len -= 1;
        next.inside[usize::from(next.len)] = 0;
        Some(next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MILK: u16 = 0;
    const GLASS: u16 = 1;
    const ICE: u16 = 2;

    fn priority(body: u16) -> i32 {
        [1, 10, 5][usize::from(body)]
    }

    fn interior(bodies: &[u16]) -> Interior {
        bodies.iter().fold(Interior::default(), |i, &b| i.with(b).unwrap())
    }

    #[test]
    fn from_air_through_the_glass_into_the_milk() {
        let air = Interior::default();
        let Crossing::Interface(glass) = air.cross(GLASS, true, priority) else { panic!() };
        assert_eq!(glass.top(priority), Some(GLASS));
        // The side of the milk lies inside the wall: no surface there.
        let Crossing::Hidden(both) = glass.cross(MILK, true, priority) else { panic!() };
        assert_eq!(both.top(priority), Some(GLASS));
        // The inner face of the glass is where glass meets milk.
        let Crossing::Interface(milk) = both.cross(GLASS, false, priority) else { panic!() };
        assert_eq!(milk.top(priority), Some(MILK));
        assert_eq!(milk.bodies(), [MILK]);
        // And up through the free surface into the air.
        assert_eq!(milk.cross(MILK, false, priority), Crossing::Interface(air));
    }

    #[test]
    fn ice_in_milk_hides_the_milk_behind_it() {
        let milk = interior(&[MILK]);
        let Crossing::Interface(ice) = milk.cross(ICE, true, priority) else { panic!() };
        assert_eq!(ice.top(priority), Some(ICE));
        // The milk's surface inside the floating ice is hidden; above it, ice meets air.
        let Crossing::Hidden(above) = ice.cross(MILK, false, priority) else { panic!() };
        assert_eq!(above.cross(ICE, false, priority), Crossing::Interface(Interior::default()));
    }

    #[test]
    fn slips_are_told_apart() {
        assert_eq!(interior(&[MILK]).cross(MILK, true, priority), Crossing::Inconsistent);
        assert_eq!(interior(&[MILK]).cross(GLASS, false, priority), Crossing::Inconsistent);
        assert_eq!(Interior::default().cross(MILK, false, priority), Crossing::Inconsistent);
        let full = interior(&[0, 1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(full.cross(9, true, |_| 0), Crossing::Inconsistent);
    }

    #[test]
    fn order_of_entry_does_not_matter() {
        let (a, b) = (interior(&[MILK, GLASS, ICE]), interior(&[ICE, MILK, GLASS]));
        assert_eq!(a.top(priority), b.top(priority));
        assert_eq!(a.without(GLASS).unwrap().top(priority), Some(ICE));
        assert_eq!(a.without(MILK).unwrap().bodies(), [GLASS, ICE]);
        // Equal priorities: the lower index, whatever the order.
        assert_eq!(interior(&[3, 2]).top(|_| 0), interior(&[2, 3]).top(|_| 0));
    }
}
