use balayage_render::gpu::{Gpu, probe::*};
use std::io::Read;
fn main() {
    let q = match std::env::args().nth(1).as_deref() { Some("draft") => Quality::Draft, Some("high") => Quality::High, _ => Quality::Standard };
    let mut s = String::new();
    std::io::stdin().read_to_string(&mut s).unwrap();
    let lines: Vec<serde_json::Value> = s.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let f = |v: &serde_json::Value| v.as_f64().unwrap();
    let three = |v: &serde_json::Value, k: f64| -> [f64; 3] { std::array::from_fn(|i| f(&v[i]) * k) };
    let d = std::f64::consts::PI / 180.0;
    let cases: Vec<ProbeCase> = lines.iter().map(|l| ProbeCase { eta: f(&l["eta"]), eccentricity: f(&l["eccentricity"]), sigma_a: three(&l["sigma_a"], 1.0), alpha: three(&l["alpha_deg"], d), beta: three(&l["beta_deg"], d), azimuthal_width: f(&l["azimuthal_width"]), theta_o: f(&l["theta_o"]), phi_o: f(&l["phi_o"]), theta_j: f(&l["theta_j"]), phi_j: f(&l["phi_j"]), lambda_j: f(&l["lambda_j"]), sigma_f: f(&l["sigma_f"]) }).collect();
    let gpu = Gpu::headless().unwrap();
    let t = std::time::Instant::now();
    let r = run(&gpu, &cases, q, Scheme::Nodes).unwrap();
    eprintln!("{:?}", t.elapsed());
    for (l, r) in lines.iter().zip(r) {
        let lobes = |v: [[f64; 3]; 3]| serde_json::json!({"R": v[0], "TT": v[1], "TRT": v[2]});
        println!("{}", serde_json::json!({"id": l["id"], "single": lobes(r.single), "global": lobes(r.global), "uniform": lobes(r.uniform_light), "a_f": r.a_f, "a_b": r.a_b, "A_b": r.a_bar_b}));
    }
}
