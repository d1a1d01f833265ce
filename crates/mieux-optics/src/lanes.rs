//! Numbers abreast: one real or complex number per problem, as wide as the registers of the machine at run time.

use std::ops::{Add, Div, Mul, Sub};

use pulp::Simd;

/// Most problems abreast on any machine.
pub(crate) const MAX_LANES: usize = 8;

/// One number per lane, as plain memory.
pub(crate) type LaneArray = [f64; MAX_LANES];

/// Takes a large step as a function of its own, compiled for wide registers once and not once for every place that takes
/// it. The closure is to be `#[inline(always)]`, and to do nothing but call.
#[inline(never)]
pub(crate) fn step<S: Simd, R>(simd: S, work: impl FnOnce() -> R) -> R {
    simd.vectorize(work)
}

/// Real numbers abreast.
#[derive(Clone, Copy)]
pub(crate) struct Re<S: Simd> {
    simd: S,
    v: S::f64s,
}

/// Complex numbers abreast.
#[derive(Clone, Copy)]
pub(crate) struct Cx<S: Simd> {
    pub re: Re<S>,
    pub im: Re<S>,
}

impl<S: Simd> Re<S> {
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Self {
        Self { simd, v: simd.splat_f64s(value) }
    }

    /// The first lanes of `from`.
    #[inline(always)]
    pub fn load(simd: S, from: &LaneArray) -> Self {
        Self { simd, v: S::as_simd_f64s(from).0[0] }
    }

    #[inline(always)]
    pub fn lanes(self) -> LaneArray {
        let mut out = [0.0; MAX_LANES];
        S::as_mut_simd_f64s(&mut out).0[0] = self.v;
        out
    }

    /// The same number in every lane.
    #[inline(always)]
    pub fn same(self, value: f64) -> Self {
        Self::splat(self.simd, value)
    }

    /// `self * b + c`.
    #[inline(always)]
    pub fn mul_add(self, b: Self, c: Self) -> Self {
        Self { simd: self.simd, v: self.simd.mul_add_e_f64s(self.v, b.v, c.v) }
    }

    /// `c - self * b`.
    #[inline(always)]
    pub fn neg_mul_add(self, b: Self, c: Self) -> Self {
        Self { simd: self.simd, v: self.simd.negate_mul_add_e_f64s(self.v, b.v, c.v) }
    }

    #[inline(always)]
    pub fn recip(self) -> Self {
        Self { simd: self.simd, v: self.simd.div_f64s(self.simd.splat_f64s(1.0), self.v) }
    }

    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { simd: self.simd, v: self.simd.abs_f64s(self.v) }
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self { simd: self.simd, v: self.simd.sqrt_f64s(self.v) }
    }

    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self { simd: self.simd, v: self.simd.max_f64s(self.v, other.v) }
    }

    /// In every lane `yes` where `self < other`, else `no`.
    #[inline(always)]
    pub fn if_less(self, other: Self, yes: Self, no: Self) -> Self {
        let simd = self.simd;
        Self { simd, v: simd.select_f64s(simd.less_than_f64s(self.v, other.v), yes.v, no.v) }
    }

    /// Whether `self < other` in any lane.
    #[inline(always)]
    pub fn any_less(self, other: Self) -> bool {
        let simd = self.simd;
        simd.first_true_m64s(simd.less_than_f64s(self.v, other.v)) < S::F64_LANES
    }

    /// Turns `(sin r, cos r)` by the quarter turns counted in the last bits of `self`.
    #[inline(always)]
    pub fn turn(self, sin: Self, cos: Self) -> (Self, Self) {
        let simd = self.simd;
        let bits = simd.transmute_u64s_f64s(self.v);
        let bit = |mask: u64| simd.equal_u64s(simd.and_u64s(bits, simd.splat_u64s(mask)), simd.splat_u64s(0));
        let (even, upper) = (bit(1), bit(2));
        let pick = |mask, a: S::f64s, b: S::f64s| Self { simd, v: simd.select_f64s(mask, a, b) };
        let (s, c) = (pick(even, sin.v, cos.v), pick(even, cos.v, sin.v));
        let one = self.same(1.0);
        let flip = pick(upper, one.v, self.same(-1.0).v);
        let odd = pick(even, one.v, self.same(-1.0).v);
        (s * flip, c * flip * odd)
    }
}

macro_rules! lane_operator {
    ($($trait:ident $method:ident $simd:ident),*) => {$(
        impl<S: Simd> $trait for Re<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { simd: self.simd, v: self.simd.$simd(self.v, other.v) }
            }
        }
    )*};
}
lane_operator!(Add add add_f64s, Sub sub sub_f64s, Mul mul mul_f64s, Div div div_f64s);

impl<S: Simd> Cx<S> {
    #[inline(always)]
    pub fn norm_sqr(self) -> Re<S> {
        self.re.mul_add(self.re, self.im * self.im)
    }

    /// `Re(self * conj(other))`.
    #[inline(always)]
    pub fn dot(self, other: Self) -> Re<S> {
        self.re.mul_add(other.re, self.im * other.im)
    }

    /// `Re(self * conj(other)) + c`.
    #[inline(always)]
    pub fn dot_add(self, other: Self, c: Re<S>) -> Re<S> {
        self.re.mul_add(other.re, self.im.mul_add(other.im, c))
    }

    /// `Im(self * conj(other))`.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Re<S> {
        self.re.neg_mul_add(other.im, self.im * other.re)
    }
}

impl<S: Simd> Add for Cx<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { re: self.re + other.re, im: self.im + other.im }
    }
}

impl<S: Simd> Sub for Cx<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { re: self.re - other.re, im: self.im - other.im }
    }
}

/// What a wave in the host is made of: real numbers where the host is lossless, complex ones where it absorbs.
pub(crate) trait Wave<S: Simd>: Copy + Add<Output = Self> + Sub<Output = Self> {
    /// A real number in every lane.
    fn splat(simd: S, value: f64) -> Self;
    fn scale(self, factor: Re<S>) -> Self;
    fn mul(self, other: Self) -> Self;
    /// `self * factor - c`, the step of every three-term recurrence here.
    fn mul_sub(self, factor: Self, c: Self) -> Self;
    /// `self * b` with a complex `b`.
    fn times(self, b: Cx<S>) -> Cx<S>;
    /// `self * b + c` with complex `b` and `c`.
    fn times_add(self, b: Cx<S>, c: Cx<S>) -> Cx<S>;
    /// `c - self * b` with complex `b` and `c`.
    fn times_sub(self, b: Cx<S>, c: Cx<S>) -> Cx<S>;
    /// `1 / self`.
    fn recip(self) -> Self;
    /// A size no smaller than the modulus and at most 1.42 times it.
    fn size(self) -> Re<S>;
}

impl<S: Simd> Wave<S> for Re<S> {
    #[inline(always)]
    fn splat(simd: S, value: f64) -> Self {
        Re::splat(simd, value)
    }
    #[inline(always)]
    fn scale(self, factor: Re<S>) -> Self {
        self * factor
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self * other
    }
    #[inline(always)]
    fn mul_sub(self, factor: Self, c: Self) -> Self {
        // The compiler folds the negation into the fused step.
        Self { simd: self.simd, v: self.simd.mul_add_e_f64s(self.v, factor.v, self.simd.neg_f64s(c.v)) }
    }
    #[inline(always)]
    fn times(self, b: Cx<S>) -> Cx<S> {
        Cx { re: self * b.re, im: self * b.im }
    }
    #[inline(always)]
    fn times_add(self, b: Cx<S>, c: Cx<S>) -> Cx<S> {
        Cx { re: self.mul_add(b.re, c.re), im: self.mul_add(b.im, c.im) }
    }
    #[inline(always)]
    fn times_sub(self, b: Cx<S>, c: Cx<S>) -> Cx<S> {
        Cx { re: self.neg_mul_add(b.re, c.re), im: self.neg_mul_add(b.im, c.im) }
    }
    #[inline(always)]
    fn recip(self) -> Self {
        Re::recip(self)
    }
    #[inline(always)]
    fn size(self) -> Re<S> {
        self.abs()
    }
}

impl<S: Simd> Wave<S> for Cx<S> {
    #[inline(always)]
    fn splat(simd: S, value: f64) -> Self {
        Cx { re: Re::splat(simd, value), im: Re::splat(simd, 0.0) }
    }
    #[inline(always)]
    fn scale(self, factor: Re<S>) -> Self {
        factor.times(self)
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Cx { re: self.im.neg_mul_add(other.im, self.re * other.re), im: self.im.mul_add(other.re, self.re * other.im) }
    }
    #[inline(always)]
    fn mul_sub(self, factor: Self, c: Self) -> Self {
        Cx {
            re: self.im.neg_mul_add(factor.im, Wave::mul_sub(self.re, factor.re, c.re)),
            im: self.im.mul_add(factor.re, Wave::mul_sub(self.re, factor.im, c.im)),
        }
    }
    #[inline(always)]
    fn times(self, b: Cx<S>) -> Cx<S> {
        Wave::mul(self, b)
    }
    #[inline(always)]
    fn times_add(self, b: Cx<S>, c: Cx<S>) -> Cx<S> {
        Cx {
            re: self.im.neg_mul_add(b.im, self.re.mul_add(b.re, c.re)),
            im: self.im.mul_add(b.re, self.re.mul_add(b.im, c.im)),
        }
    }
    #[inline(always)]
    fn times_sub(self, b: Cx<S>, c: Cx<S>) -> Cx<S> {
        Cx {
            re: self.im.mul_add(b.im, self.re.neg_mul_add(b.re, c.re)),
            im: self.im.neg_mul_add(b.re, self.re.neg_mul_add(b.im, c.im)),
        }
    }
    #[inline(always)]
    fn recip(self) -> Self {
        let scale = Re::recip(self.norm_sqr());
        Cx { re: self.re * scale, im: self.im.neg_mul_add(scale, scale.same(0.0)) }
    }
    #[inline(always)]
    fn size(self) -> Re<S> {
        self.re.abs() + self.im.abs()
    }
}
