//! `balayage probe`: the contract of its lines.

use balayage::cli::method_options::MethodOptions;
use balayage::cli::probe::{self, Arguments, Backend, Report};
use serde_json::{Value, json};

/// A case that every test changes a little.
fn case() -> Value {
    json!({
        "id": "a", "eta": 1.55, "eccentricity": 1.0, "sigma_a": [0.1, 0.2, 0.4],
        "alpha_deg": [-5.0, 2.5, 7.5], "beta_deg": [6.0, 3.0, 12.0], "azimuthal_width": 0.2,
        "theta_o": 0.3, "phi_o": 0.1, "theta_j": -0.2, "phi_j": 2.0, "lambda_j": 0.4, "sigma_f": 0.5,
    })
}

/// What the reference answers to lines.
fn probe(lines: &str) -> (Vec<Value>, Report) {
    let mut out = Vec::new();
    let arguments = Arguments {
        backend: Backend::Reference,
        method: MethodOptions::default(),
    };
    let report = probe::run(&arguments, lines.as_bytes(), &mut out).unwrap();
    let text = String::from_utf8(out).unwrap();
    (
        text.lines()
            .map(|line| serde_json::from_str(line).unwrap())
            .collect(),
        report,
    )
}

#[test]
fn answers_come_in_order_with_every_key() {
    let mut second = case();
    second["id"] = json!(2);
    let deon = json!({
        "id": "d", "model": "deon", "eta": 1.55, "eccentricity": 1.0, "sigma_a": [0.1, 0.2, 0.4],
        "alpha_deg": [0, 0, 0], "deon_beta_long": 0.2, "deon_beta_azimuth": 0.3,
        "theta_o": 0.3, "phi_o": 0.1, "theta_j": -0.2, "phi_j": 2.0, "lambda_j": 0.4,
    });
    let kay = json!({"id": null, "model": "kajiya-kay", "theta_j": 0.3, "lambda_j": 0.5});
    let (answers, report) = probe(&format!("{}\n{second}\n\n{deon}\n{kay}\n", case()));
    assert_eq!(report, Report { lines: 4, refused: 0 });
    assert_eq!(
        answers.iter().map(|a| a["id"].clone()).collect::<Vec<_>>(),
        [json!("a"), json!(2), json!("d"), Value::Null]
    );
    assert_eq!(answers[0]["single"], answers[1]["single"]);
    for key in ["R", "TT", "TRT"] {
        assert_eq!(answers[0]["single"][key].as_array().unwrap().len(), 3);
        assert_eq!(answers[0]["global"][key].as_array().unwrap().len(), 3);
    }
    for key in ["a_f", "a_b", "A_b"] {
        assert_eq!(answers[0][key].as_array().unwrap().len(), 3);
    }
    assert_eq!(
        answers[2]["single"]
            .as_object()
            .unwrap()
            .keys()
            .collect::<Vec<_>>(),
        ["0", "1", "2", "3"]
    );
    assert_eq!(answers[3]["diffuse"].as_array().unwrap().len(), 3);
}

#[test]
fn bad_lines_are_answered_and_the_run_goes_on() {
    let changed = |key: &str, value: Value| {
        let mut line = case();
        line[key] = value;
        line.to_string()
    };
    let without = |key: &str| {
        let mut line = case();
        line.as_object_mut().unwrap().remove(key);
        line.to_string()
    };
    let bad = [
        ("not JSON", "{\"id\": 1, \"eta\": NaN}".to_owned()),
        ("not JSON", "{\"id\": 1, \"eta\": 1e999}".to_owned()),
        ("not an object", "[1, 2]".to_owned()),
        ("eta", changed("eta", json!(0.0))),
        ("eta", without("eta")),
        ("eccentricity", changed("eccentricity", json!(-1))),
        ("3", changed("sigma_a", json!([1, 2]))),
        ("sigma_a[2]", changed("sigma_a", json!([1, 2, -3]))),
        ("beta_deg[1]", changed("beta_deg", json!([5, 0, 5]))),
        ("alpha_deg[0]", changed("alpha_deg", json!([500, 0, 5]))),
        ("azimuthal_width", changed("azimuthal_width", json!(0))),
        ("theta_o", changed("theta_o", json!(2))),
        ("theta_j", changed("theta_j", json!(-2))),
        ("lambda_j", changed("lambda_j", json!(0))),
        ("sigma_f", changed("sigma_f", json!(-0.1))),
        ("model", changed("model", json!("phong"))),
        ("deon_beta_long", changed("model", json!("deon"))),
    ];
    let text: String = bad
        .iter()
        .map(|(_, line)| format!("{line}\n"))
        .chain([case().to_string()])
        .collect();
    let (answers, report) = probe(&text);
    assert_eq!(
        report,
        Report {
            lines: bad.len() + 1,
            refused: bad.len()
        }
    );
    for ((place, line), answer) in bad.iter().zip(&answers) {
        let error = answer["error"]
            .as_str()
            .unwrap_or_else(|| panic!("{line} was answered: {answer}"));
        assert!(error.contains(place), "{line}: {error}");
    }
    assert!(answers[bad.len()].get("error").is_none());
}
