//! Laws behind pointers.

use std::sync::Arc;

use gfmd_law::{Exponential, Law, LawKind, Separation, XuNeedleman};

#[test]
fn a_pointer_to_a_law_is_that_law() {
    let work = Separation { normal_work: 1.0, tangential_work: 0.5, normal_length: 0.1, tangential_length: 0.2 };
    let law = XuNeedleman::new(work, 0.3).unwrap();
    let shared: Arc<dyn Law> = Arc::new(law);
    let boxed: Box<dyn Law> = Box::new(law);
    let (normal, sliding) = (0.07, [0.03, -0.05]);
    for pointer in [&shared as &dyn Law, &boxed] {
        assert_eq!(pointer.response(normal, 0.04), law.response(normal, 0.04));
        assert_eq!(pointer.energy(normal, 0.04), law.energy(normal, 0.04));
        assert_eq!(pointer.opening_energy(normal), law.opening_energy(normal));
        assert_eq!(pointer.opening(normal), law.opening(normal));
        assert_eq!(pointer.traction(normal, sliding), law.traction(normal, sliding));
        assert_eq!(pointer.jacobian(normal, sliding), law.jacobian(normal, sliding));
        assert_eq!(pointer.mixed_mode(), law.mixed_mode());
        assert_eq!(
            [pointer.stiffness_bound(-0.01), pointer.steepness()],
            [law.stiffness_bound(-0.01), law.steepness()]
        );
        assert!(!pointer.has_wall());
    }
    assert!(Exponential::new(1.0, 0.1).unwrap().into_shared().has_wall());
    assert!(LawKind::HardWall.with(&[] as &[(&str, f64)]).unwrap().into_shared().has_wall());
    let again = Arc::clone(&shared).into_shared();
    assert!(Arc::ptr_eq(&again, &shared), "no second pointer");
}
