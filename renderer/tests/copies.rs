//! Copies are met the same way by every instruction set, alone and together with other rays.

use glam::Vec3;
use kinora_kernel::generated::{FAR, NONE};
use kinora_kernel::query::{BATCH, Hits, Isa, Rays, bvh_any, bvh_any_many, bvh_closest, bvh_closest_many};
use kinora_renderer::pack;
use kinora_renderer::suite::many_copies;

/// xorshift: other numbers for every ray.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        (self.0 >> 8) as f32 / (1 << 24) as f32
    }

    fn direction(&mut self) -> Vec3 {
        loop {
            let v = Vec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0;
            if v.length_squared() > 0.01 && v.length_squared() < 1.0 {
                return v.normalize();
            }
        }
    }
}

#[test]
fn all_walks_find_the_same() {
    let packed = pack(&many_copies()).expect("it packs");
    packed.validate().expect("it is valid");
    let mut r = Random(0x9e37_79b9);
    let rays: Vec<(Vec3, Vec3, f32)> = (0..20_000)
        .map(|_| {
            let o = Vec3::new(r.next() * 8.0 - 4.0, r.next() * 3.0, r.next() * 8.0 - 4.0);
            let t_max = if r.next() < 0.5 { FAR } else { r.next() * 4.0 };
            (o, r.direction(), t_max)
        })
        .collect();
    let want: Vec<_> = packed.with_kernel_on(Isa::Portable, |k| {
        rays.iter().map(|&(o, d, t_max)| (bvh_closest(k, o, d, t_max, NONE), bvh_any(k, o, d, t_max, NONE))).collect()
    });
    let inside = want.iter().filter(|(hit, _)| hit.id != NONE && hit.instance != NONE).count();
    assert!(inside > 500, "{inside} rays meet copies");
    for (hit, any) in &want {
        assert_eq!(hit.id != NONE, *any, "{hit:?}");
    }
    for isa in [Isa::Portable, Isa::Avx2, Isa::Avx512] {
        packed.with_kernel_on(isa, |k| {
            for (&(o, d, t_max), (hit, any)) in rays.iter().zip(&want) {
                assert_eq!((bvh_closest(k, o, d, t_max, NONE), bvh_any(k, o, d, t_max, NONE)), (*hit, *any), "{isa:?}");
            }
            for (i, chunk) in rays.chunks_exact(BATCH).enumerate() {
                let mut batch = Rays::default();
                for (lane, (o, d, t_max)) in chunk.iter().enumerate() {
                    for axis in 0..3 {
                        (batch.o[axis][lane], batch.d[axis][lane]) = (o[axis], d[axis]);
                    }
                    (batch.t_max[lane], batch.start[lane]) = (*t_max, NONE);
                }
                let active = (i as u32).wrapping_mul(0x9e37_79b9) & ((1_u64 << BATCH) - 1) as u32;
                let mut hits = Hits::default();
                let found = bvh_closest_many(k, &batch, active, &mut hits);
                let any = bvh_any_many(k, &batch, active);
                for lane in (0..BATCH).filter(|lane| active >> lane & 1 == 1) {
                    let (hit, met) = want[i * BATCH + lane];
                    assert_eq!((found >> lane & 1 == 1, any >> lane & 1 == 1), (met, met), "{isa:?}");
                    if met {
                        let got = (hits.t[lane], hits.id[lane], hits.u[lane], hits.v[lane], hits.instance[lane]);
                        assert_eq!(got, (hit.t, hit.id, hit.uv.x, hit.uv.y, hit.instance), "{isa:?}");
                    }
                }
            }
        });
    }
}
