//! Tests of the result configurations of all commands.

use gfmd_check::result::{Configuration, FILES, ResultKind};
use gfmd_contact::Boundary;
use gfmd_problem::options::flags::{self, keys as keys_of};
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use crate::{body, contact, path, punch};

#[test]
fn a_configuration_is_a_problem_and_flags() {
    let config = "young = 2.0\np_star = [0.01, -0.5]\nflip = true\ndetrend = \"none\"\nstatistics = false\n\
                  height = inf\nparam = [[\"gamma\", 1e-4], [\"range\", 0.003]]\nplots = \"p\"\n\
                  surface = \"/dev/zero\"\nhardness = \"h.npy\"\nhistory_mode = [[1, -2, \"z\"]]\n\
                  boundary = \"free\"\n";
    let found = Configuration::read::<contact::Args>(ResultKind::Contact, config).unwrap();
    let wanted = [
        "--boundary=free",
        "--detrend=none",
        "--flip",
        "--hardness=h.npy",
        "--height=inf",
        "--history-mode=1,-2,z",
        "--p-star=0.01,-0.5",
        "--param=gamma=0.0001",
        "--param=range=0.003",
        "--surface=/dev/zero",
        "--young=2.0",
    ];
    let mut words = found.words();
    words.sort();
    assert_eq!(words, wanted);
    assert!(found.has("surface") && !found.has("plots"));
    // Files come from the result alone.
    let (young, surface) = ("young".to_owned(), Table::from_iter([("surface".to_owned(), "r.h5:/h".into())]));
    let problem = |stored: Table| found.problem::<contact::Args>(std::slice::from_ref(&young), stored).unwrap();
    let table = |stored: Table| Table::try_from(problem(stored)).unwrap();
    let bare = table(Table::new());
    assert!(!bare.contains_key("surface") && !bare.contains_key("hardness"));
    let (one, free) = (Value::Float(1.0), Value::String(Boundary::Free.name().into()));
    assert_eq!((&bare["young"], &bare["boundary"], &bare["flip"]), (&one, &free, &Value::Boolean(true)));
    assert_eq!(table(surface)["surface"].as_str(), Some("r.h5:/h"));
}

#[test]
fn other_keys_and_other_types_are_refused_in_one_line() {
    for (config, words) in [
        ("young = ", "config of the file: "),
        ("evil = 1", "\"evil\" is no key of a result of contact"),
        ("\"--out\" = \"x\"", "\"--out\" is no key"),
        ("\"a\\nb\" = 1", "\"a\\nb\" is no key"),
        ("threads = 1", "\"threads\" is no key"),
        ("young = \"--out=x\"", "young is \"--out=x\": invalid type: string"),
        ("young = [1.0]", "young is [1.0]: invalid type: sequence"),
        ("law = \"--out=x\"", "law is \"--out=x\": "),
        ("law = \"morse\\n--out=x\"", "law is \"morse\\n--out=x\": "),
        ("law = [\"morse\"]", "law is [\"morse\"]: "),
        ("law = \"\"", "law is \"\": "),
        ("solver = \"best\"", "solver is \"best\": it must be one of auto, "),
        ("boundary = \"open\"", "boundary is \"open\": it must be one of periodic, free"),
        ("height = \"deep\"", "height is \"deep\": it must be a number, or \"inf\""),
        ("layer = [[1.0]]", "layer is [[1.0]]: it must be E, NU"),
        ("seed = -1", "seed is -1: "),
        ("dim = 4", "dim is 4: it must be a whole number from 2 to 3"),
        ("size = [1.0, 2.0, 3.0]", "it has 3 values; it must have 1 to 2"),
        ("seed = 18446744073709551615", "config of the file: "),
        ("p_star = 0.1", "p_star is 0.1: invalid type"),
        ("p_star = [\"1:2:3\"]", "p_star is [\"1:2:3\"]: invalid type"),
        ("param = [[\"gamma\", 1.0, 2.0]]", "param is [[\"gamma\", 1.0, 2.0]]: "),
        ("history_point = [[0.0, 0.0, \"--out\"]]", "it must be X,Y,COMPONENT"),
        ("surface = 1", "surface is 1: invalid type"),
        ("flip = \"yes\"", "flip is \"yes\": invalid type"),
        ("[young]\nx = 1", "young is "),
    ] {
        let message = Configuration::read::<contact::Args>(ResultKind::Contact, config).unwrap_err().to_string();
        assert!(message.contains(words) && message.starts_with("config of the file: "), "{config}: {message}");
        assert!(!message.contains('\n') && message.len() < 700, "{message}");
    }
    let long = format!("law = \"{}\"", "a".repeat(10_000));
    assert!(Configuration::read::<contact::Args>(ResultKind::Contact, &long).unwrap_err().to_string().len() < 700);
}

#[test]
fn what_a_command_says_of_itself_is_read_again() {
    fn again<A: DeserializeOwned + serde::Serialize + Default>() {
        let words = toml::to_string(&A::default()).unwrap();
        let read: A = flags::of_table(words.parse().unwrap()).unwrap();
        assert_eq!(toml::to_string(&read).unwrap(), words);
    }
    again::<contact::Args>();
    again::<path::Args>();
    again::<punch::Args>();
    for keys in [keys_of::<contact::Args>(), keys_of::<path::Args>(), keys_of::<punch::Args>(), keys_of::<body::Args>()]
    {
        assert!(keys.len() > 10 && FILES.iter().any(|file| keys.iter().any(|key| key == file)), "{keys:?}");
    }
}
