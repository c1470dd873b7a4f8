//! Every check of every topic meets its bound, as printed by `cargo xtask verify`.

use gfmd_tests::{Reference, TOPICS, Topic, ValidationError};

fn topic(name: &str) -> &'static Topic {
    TOPICS.iter().find(|topic| topic.name == name).unwrap()
}

fn holds(topic: &Topic) {
    let checks = (topic.checks)(&Reference::default()).unwrap();
    assert!(!checks.is_empty());
    let failed: Vec<String> = checks.iter().filter(|check| !check.passes()).map(|check| format!("{check:?}")).collect();
    assert!(failed.is_empty(), "{}:\n{}", topic.title, failed.join("\n"));
}

/// Defines one test per topic, so that they run in parallel, and one test that all topics are covered.
macro_rules! topics {
    ($($name:ident),+) => {
        $(
            #[test]
            fn $name() {
                holds(topic(stringify!($name)));
            }
        )+

        #[test]
        fn no_topic_is_left_out() {
            assert_eq!(TOPICS.map(|topic| topic.name).to_vec(), [$(stringify!($name)),+]);
        }
    };
}
topics!(
    limits, kernels, inside, punch, damping, analytic, exact, bounded, plastic, layered, laws, friction, patch, moving,
    squeezed, steep
);

#[test]
fn a_missing_file_is_named() {
    let error = (topic("kernels").checks)(&Reference::new("nowhere")).unwrap_err();
    assert!(matches!(&error, ValidationError::Reference { file, .. } if file.contains("slab_kernel_2d.json")));
}
