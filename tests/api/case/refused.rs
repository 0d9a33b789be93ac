//! Bad input: every row is one change of a good case, the pointer its fault must carry, and words of the message.

use super::common::{base_with, faults, text_with};

/// `--set` values (`;` between several), pointer, words that the fault's paragraph contains.
type Row<'a> = (&'a str, &'a str, &'a str);

fn sets(text: &str) -> Vec<(&str, &str)> {
    text.split(';').map(|pair| pair.split_once('=').expect("key=value")).collect()
}

fn refuses(rows: &[Row<'_>]) {
    for (change, pointer, words) in rows {
        let list = faults(base_with(&sets(change)));
        let hit = list.iter().find(|f| f.pointer == *pointer);
        let hit = hit.unwrap_or_else(|| panic!("{change}: no fault at {pointer}, but {list:#?}"));
        assert!(hit.to_string().contains(words), "{change}: \"{words}\" is not in\n{hit}");
        assert_eq!(list.len(), 1, "{change}: one change should make one fault: {list:#?}");
    }
}

/// Wrong types, unknown and missing keys lead to the key itself, with the nearest known one.
#[test]
fn types_and_keys() {
    refuses(&[
        ("time.step=abc", "/time/step", "a number"),
        ("time.stepp=1", "/time/stepp", "did you mean \"step\""),
        ("system.network.suports=[]", "/system/network/suports", "did you mean \"supports\""),
        ("time.end=null", "/time/end", "required"),
        ("time.method=3", "/time/method", "a word in double quotes or an object {...} with one key"),
        ("time.method={}", "/time/method", "one key"),
        ("time.method={\"hht\":{},\"rk4\":{}}", "/time/method", "one key"),
        ("time.method={\"hht\":{\"alpha\":\"x\"}}", "/time/method/hht/alpha", "a number"),
        ("system.network.springs.0.on=al", "/system/network/springs/0/on", "did you mean \"all\""),
        ("system.network.springs.0.on=3", "/system/network/springs/0/on", "a word in double quotes"),
        ("system.network.springs.0.on={\"ids\":[-1]}", "/system/network/springs/0/on/ids/0", "0 to 4294967295"),
        ("system.network.springs.0.on={\"ids\":[1.5]}", "/system/network/springs/0/on/ids/0", "0 to 4294967295"),
        ("system.network.springs.0.on={\"all\":1}", "/system/network/springs/0/on/all", "the plain word"),
        (
            "system.network.springs.0.slack=dead_zone",
            "/system/network/springs/0/slack",
            "its key: {\"dead_zone\": ...}",
        ),
        ("system.network.springs.0.slack={}", "/system/network/springs/0/slack", "one key"),
        ("system.network.gravity=[0,0]", "/system/network/gravity", "exactly 3"),
        ("system.network.gravity=[0,0,1,1]", "/system/network/gravity", "exactly 3"),
        ("system.network.gravity=9.81", "/system/network/gravity", "a vector [x, y, z]"),
        ("system.network.mass.nodal=heavy", "/system/network/mass/nodal", "a number or a list"),
        ("system.network.mass.nodal=[1,\"x\"]", "/system/network/mass/nodal/1", "a number"),
        ("system.network.initial.velocity=[[0,0,0],1]", "/system/network/initial/velocity/1", "a vector [x, y, z]"),
        ("system.network.initial.velocity=[1,2]", "/system/network/initial/velocity", "a vector [x, y, z]"),
        ("system.network.initial.velocity=fast", "/system/network/initial/velocity", "a vector [x, y, z]"),
        ("system.network.springs={}", "/system/network/springs", "a list"),
        ("system=network", "/system", "its key: {\"network\": ...}"),
        ("system={\"pendlum\":{\"length\":1,\"mass\":1,\"gravity\":1,\"angle\":1}}", "/system/pendlum", "\"pendulum\""),
        ("time.step=1e999", "/time/step", "a number"),
        ("output.fields=[\"stress\"]", "/output/fields/0", "tension"),
        ("output=5", "/output", "an object"),
    ]);
}

/// Times, methods and solvers.
#[test]
fn time_and_solver() {
    refuses(&[
        ("time.step=0", "/time/step", "a number above 0"),
        ("time.step=-0.01", "/time/step", "a number above 0"),
        ("time.end=0", "/time/end", "a number above 0"),
        ("time.step=null", "/time/step", "fixed step"),
        ("time.tolerance={\"relative\":1e-4,\"absolute\":1e-6}", "/time/tolerance", "not together"),
        (
            "time.step=null;time.tolerance={\"relative\":1e-14,\"absolute\":1e-6}",
            "/time/tolerance/relative",
            "from 1e-13 to below 1",
        ),
        ("time.step=null;time.tolerance={\"relative\":1,\"absolute\":1e-6}", "/time/tolerance/relative", "below 1"),
        ("time.step=null;time.tolerance={\"relative\":0.1,\"absolute\":0}", "/time/tolerance/absolute", "above 0"),
        ("time.step=null;time.tolerance={\"relative\":0.1}", "/time/tolerance/absolute", "required"),
        (
            "time.step=null;time.tolerance={\"relative\":0.1,\"absolute\":1};system.network.springs.0.dashpot={\"axial\":\"step\"}",
            "/system/network/springs/0/dashpot/axial",
            "adaptive steps",
        ),
        ("time.step=1e-300", "/time/step", "at least"),
        ("time.method=newmrk", "/time/method", "did you mean \"newmark\""),
        ("time.method={\"hht\":{\"alfa\":0}}", "/time/method/hht/alfa", "did you mean \"alpha\""),
        ("time.method={\"htt\":{}}", "/time/method/htt", "did you mean \"hht\""),
        ("time.method={\"hht\":{\"alpha\":0.1}}", "/time/method/hht/alpha", "-0.333"),
        ("time.method={\"rk4\":{\"alpha\":0.1}}", "/time/method/rk4/alpha", "none"),
        ("solver.linear=qr", "/solver/linear", "cg"),
        ("solver.newton.relative=0", "/solver/newton/relative", "above 0 and below 1"),
        ("solver.newton.max_iterations=0", "/solver/newton/max_iterations", "1 to 1000"),
        ("name=", "/name", "1 to 200"),
    ]);
}

/// Springs, dashpots and masses.
#[test]
fn springs_and_mass() {
    refuses(&[
        ("system.network.springs.0.stiffness=0", "/system/network/springs/0/stiffness", "above 0"),
        ("system.network.springs.0.stiffness=null", "/system/network/springs/0", "exactly one of"),
        ("system.network.springs.0.axial_rigidity=1", "/system/network/springs/0", "exactly one of"),
        ("system.network.springs.0.rest_length=-1", "/system/network/springs/0/rest_length", "0 or more"),
        ("system.network.springs.0.rest_scale=-1", "/system/network/springs/0/rest_scale", "above 0"),
        (
            "system.network.springs.0.rest_length=1;system.network.springs.0.rest_scale=1",
            "/system/network/springs/0/rest_scale",
            "keep one",
        ),
        ("system.network.springs.0.linear_density=-1", "/system/network/springs/0/linear_density", "0 or more"),
        ("system.network.springs.0.slack={\"dead_zone\":-1}", "/system/network/springs/0/slack/dead_zone", "0 or more"),
        (
            "system.network.springs.0.dashpot={\"axial\":{\"time\":-1}}",
            "/system/network/springs/0/dashpot/axial/time",
            "0 or more",
        ),
        (
            "system.network.springs.0={\"on\":\"all\",\"membrane\":{\"modulus\":1,\"thickness\":1}}",
            "/system/network/springs/0/membrane",
            "edges without triangles: 5",
        ),
        ("system.network.springs.0.on=seams", "/system/network/springs/0/on", "6 edges, 4 of them \"boundary\""),
        ("system.network.springs.0.on={\"ids\":[6]}", "/system/network/springs/0/on/ids/0", "from 0 to 5"),
        ("system.network.springs.0.on={\"ids\":[]}", "/system/network/springs/0/on/ids", "at least one"),
        ("system.network.springs.0.on={\"ids\":[1,1]}", "/system/network/springs/0/on/ids", "edge 1 twice"),
        ("system.network.mass.nodal=-1", "/system/network/mass/nodal", "0 or more"),
        ("system.network.mass.nodal=[1,1,1,1,-1]", "/system/network/mass/nodal/4", "0 or more"),
        ("system.network.mass.nodal=[1,1]", "/system/network/mass/nodal", "a list of 5"),
        ("system.network.mass.nodal=null", "/system/network/mass", "free nodes 4 (0 kg"),
        ("system.network.mass=null", "/system/network/mass", "free nodes 1, 2, 3, 4"),
    ]);
}

/// Membranes, bending, and laws of springs.
#[test]
fn membranes_bending_and_laws() {
    let membranes = |more: &str, words: &'static str, key: &'static str| {
        let rest = [("thickness", "1e-3"), ("poisson", "0.2")].into_iter().filter(|(key, _)| !more.contains(key));
        let rest: String = rest.map(|(key, value)| format!("\"{key}\":{value},")).collect();
        (
            format!("system.network.membranes=[{{\"on\":\"all\",{rest}{more}}}]"),
            format!("/system/network/membranes/0{key}"),
            words,
        )
    };
    let two = r#""modulus":[2e6,1e6]"#;
    let bending = |more: &str, words: &'static str, key: &'static str| {
        let change = format!("system.network.bending=[{{\"on\":\"all\"{more}}}]");
        (change, format!("/system/network/bending/0{key}"), words)
    };
    let springs = |more: &str, words: &'static str, key: &'static str| {
        let change = format!("system.network.springs=[{{\"on\":\"all\",{more}}}]");
        (change, format!("/system/network/springs/0{key}"), words)
    };
    let rows = [
        membranes(r#""modulus":-1"#, "above 0", "/modulus"),
        membranes(&format!(r#"{two},"warp":[1,0,0]"#), "two moduli without shear", ""),
        membranes(&format!(r#"{two},"shear":1e5"#), "two moduli without a warp", ""),
        membranes(r#""modulus":[2e6,0],"shear":1e5,"warp":[1,0,0]"#, "above 0", "/modulus/1"),
        membranes(&format!(r#"{two},"warp":[1,0,0],"shear":-1"#), "above 0", "/shear"),
        membranes(r#""modulus":1e6,"shear":1e5"#, "only with two moduli", "/shear"),
        membranes(r#""modulus":1e6,"damping_time":-1"#, "0 or more", "/damping_time"),
        membranes(r#""modulus":1e6,"thickness":0"#, "above 0", "/thickness"),
        membranes(r#""modulus":1e6,"poisson":1"#, "below 1", "/poisson"),
        membranes(
            r#""modulus":[1e6,9e6],"shear":1e5,"warp":[1,0,0],"poisson":0.4"#,
            "poisson^2 E2 below E1",
            "/poisson",
        ),
        membranes(r#""modulus":1e6,"warp":[0,0,0]"#, "not zero", "/warp"),
        membranes(r#""modulus":1e6,"warp":[0,0,1]"#, "at right angles to triangles 0, 1", "/warp"),
        bending("", "without stiffness", ""),
        bending(r#","stiffness":1,"flexural_rigidity":1"#, "both stiffnesses", ""),
        bending(r#","stiffness":-1"#, "above 0", "/stiffness"),
        bending(r#","flexural_rigidity":1"#, "edges that can bend", "/on"),
        springs(r#""law":"green""#, "exactly one of", ""),
        springs(r#""law":"greene","stiffness":1"#, "did you mean \"green\"", "/law"),
        springs(r#""law":"green","stiffness":1,"rest_length":0"#, "this law needs a rest length", "/rest_length"),
        springs(r#""law":{"table":[[0,0]]}"#, "1 row", "/law/table"),
        springs(r#""law":{"table":[[0,0],[0.1,2],[0.2,1]]}"#, "do not fall", "/law/table/2"),
        springs(r#""law":{"table":[[0,0],[0.1,2],[0.05,3]]}"#, "strictly increasing", "/law/table/2"),
        springs(r#""law":{"table":[[0,1],[0.1,2]]}"#, "1 N at the strain 0", "/law/table"),
        springs(r#""law":{"table":[[0.1,1],[0.2,2]]}"#, "no strain 0 within the rows", "/law/table"),
        springs(r#""law":{"table":[[0,0],[0.1,0]]}"#, "a curve that rises", "/law/table"),
        springs(r#""law":{"table":[[0,0],[0.1,2]]},"stiffness":1"#, "a stiffness and a table", ""),
        springs(
            r#""law":"green","stiffness":1,"slack":{"compression_limit":0.1},"rest_scale":{"table":[[0,1],[1,2]]}"#,
            "a linear law with compression_limit",
            "/law",
        ),
    ];
    for (change, pointer, words) in &rows {
        refuses(&[(change, pointer, words)]);
    }
}

/// Meshes, supports, and what cannot move.
#[test]
fn mesh_and_supports() {
    refuses(&[
        ("system.network.mesh={\"file\":\"no-such.vtu\"}", "/system/network/mesh/file", "no-such.vtu"),
        ("system.network.mesh={\"explicit\":{\"nodes\":[]}}", "/system/network/mesh/explicit/nodes", "0 nodes"),
        ("system.network.mesh.explicit.nodes.1=[0,0,0]", "/system/network/mesh/explicit", "coincide"),
        ("system.network.mesh.explicit.springs.0=[0,9]", "/system/network/mesh/explicit/springs/0", "0 to 4"),
        ("system.network.mesh.explicit.triangles.0=[0,1,9]", "/system/network/mesh/explicit/triangles/0", "0 to 4"),
        ("system.network.mesh.explicit.nodes.1=[0.5,0.5,0]", "/system/network/mesh/explicit", "degenerate"),
        (
            "system.network.mesh={\"annulus\":{\"inner_radius\":0.1,\"outer_radius\":1,\"nodes\":1000000000000}}",
            "/system/network/mesh/annulus/nodes",
            "take fewer",
        ),
        ("system.network.supports.0.on={\"ids\":[5]}", "/system/network/supports/0/on/ids/0", "from 0 to 4"),
        ("system.network.supports.0.on=inner", "/system/network/supports/0/on", "4 \"outer\", 0 \"inner\""),
        (
            "system.network.supports.0.on={\"box\":[[5,5,5],[6,6,6]]}",
            "/system/network/supports/0/on",
            "lie between [0.0, 0.0, 0.0] and [2.0, 1.0, 0.0]",
        ),
        ("system.network.supports.0.on={\"box\":[[1,0,0],[0,0,0]]}", "/system/network/supports/0/on/box", "lowest"),
        (
            "system.network.supports.0.on={\"sphere\":{\"center\":[0,0,0],\"radius\":0}}",
            "/system/network/supports/0/on/sphere/radius",
            "above 0",
        ),
        ("system.network.supports.0.fix=xx", "/system/network/supports/0/fix", "each once"),
        ("system.network.supports.0.fix=", "/system/network/supports/0/fix", "one or more"),
        ("system.network.supports.0.fix=xw", "/system/network/supports/0/fix", "letters"),
        ("system.network.supports.0.on=all", "/system/network/supports", "something that can move"),
    ]);
}

/// The air, loads, damping and the initial state.
#[test]
fn air_loads_and_start() {
    refuses(&[
        (
            "system.network.aero={\"wind\":{\"table\":[[0,0,0,1],[0,0,0,2]]},\"law\":{\"pressure_coefficient\":{\"cp\":1}}}",
            "/system/network/aero/wind/table/1",
            "strictly increasing",
        ),
        (
            "system.network.aero={\"wind\":{\"table\":[]},\"law\":{\"pressure_coefficient\":{\"cp\":1}}}",
            "/system/network/aero/wind/table",
            "at least one row",
        ),
        (
            "system.network.aero={\"wind\":{\"tabel\":[[0,0,0,1]]},\"law\":{\"pressure_coefficient\":{\"cp\":1}}}",
            "/system/network/aero/wind/tabel",
            "did you mean \"table\"",
        ),
        (
            "system.network.aero={\"wind\":5,\"law\":{\"pressure_coefficient\":{\"cp\":1}}}",
            "/system/network/aero/wind",
            "a vector [x, y, z] of exactly 3 numbers or",
        ),
        (
            "system.network.aero={\"wind\":[0,0,1],\"law\":{\"ergun\":{\"porosity\":1,\"pore_diameter\":1e-4,\"thickness\":1e-4}}}",
            "/system/network/aero/law/ergun/porosity",
            "above 0 and below 1",
        ),
        (
            "system.network.aero={\"wind\":[0,0,1],\"law\":{\"permeable\":{\"a\":0,\"b\":0,\"thickness\":1e-4}}}",
            "/system/network/aero/law/permeable",
            "a or b above 0",
        ),
        (
            "system.network.mesh.explicit.triangles.1=[0,3,2];system.network.loads=[{\"on\":\"all\",\"pressure\":1}]",
            "/system/network/loads/0",
            "opposite ways",
        ),
        (
            "system.network.mesh.explicit.triangles.1=[0,3,2];system.network.aero={\"wind\":[0,0,1],\"law\":{\"pressure_coefficient\":{\"cp\":1}}}",
            "/system/network/aero",
            "opposite ways",
        ),
        (
            "system.network.mesh.explicit.triangles=[];system.network.mass.areal_density=null;system.network.loads=[{\"on\":\"all\",\"pressure\":1}]",
            "/system/network/loads/0",
            "without triangles",
        ),
        ("system.network.mesh.explicit.triangles=[]", "/system/network/mass/areal_density", "without triangles"),
        (
            "system.network.loads=[{\"on\":\"all\"}]",
            "/system/network/loads/0",
            "exactly one of pressure, force and snow",
        ),
        ("system.network.loads=[{\"on\":\"outer\",\"pressure\":1}]", "/system/network/loads/0/on", "acts on triangles"),
        (
            "system.network.loads=[{\"on\":{\"ids\":[2]},\"pressure\":1}]",
            "/system/network/loads/0/on/ids/0",
            "triangle numbers from 0 to 1",
        ),
        (
            "system.network.loads=[{\"on\":\"all\",\"pressure\":1,\"kind\":\"dead\",\"direction\":[0,0,0]}]",
            "/system/network/loads/0/direction",
            "not zero",
        ),
        (
            "system.network.loads=[{\"on\":\"all\",\"pressure\":1,\"direction\":[0,0,1]}]",
            "/system/network/loads/0/direction",
            "\"kind\": \"dead\"",
        ),
        (
            "system.network.loads=[{\"on\":\"all\",\"force\":[0,0,1],\"kind\":\"dead\"}]",
            "/system/network/loads/0/kind",
            "only with pressure",
        ),
        (
            "system.network.loads=[{\"on\":\"all\",\"force\":[0,0,1],\"table\":[[1,1],[0,1]]}]",
            "/system/network/loads/0/table/1",
            "time 0 after 1",
        ),
        ("system.network.damping={\"rayleigh\":{\"mass\":-1}}", "/system/network/damping/rayleigh/mass", "0 or more"),
        (
            "system.network.initial.velocity=[[1,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0]]",
            "/system/network/initial/velocity/0",
            "holds its node",
        ),
        ("system.network.initial.velocity=[[0,0,0]]", "/system/network/initial/velocity", "a list of 5"),
        (
            "system.network.initial.displacement=[[1,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0]]",
            "/system/network/initial/displacement",
            "edges 0",
        ),
    ]);
}

/// Output and study.
#[test]
fn output_and_study() {
    refuses(&[
        ("output.frames.every=0", "/output/frames/every", "above 0"),
        ("output.frames.every=1e-9", "/output/frames/every", "999999 frames"),
        ("output.history.every=0", "/output/history/every", "1 or more"),
        ("output.probes=[{\"name\":\"a\",\"on\":\"middle\"}]", "/output/probes/0/on", "known names here"),
        ("output.probes=[{\"name\":\"a\",\"on\":\"inner\"}]", "/output/probes/0/on", "at least one node"),
        (
            "output.probes=[{\"name\":\"a\",\"on\":\"all\"},{\"name\":\"a\",\"on\":\"all\"}]",
            "/output/probes/1/name",
            "no other probe",
        ),
        ("study.methods=[\"rk5\"]", "/study/methods/0", "did you mean \"rk4\""),
        ("study.steps=[0.1,0]", "/study/steps/1", "above 0"),
        ("study.steps=[]", "/study/steps", "at least one"),
        ("study.tolerances=[1]", "/study/tolerances/0", "below 1"),
        ("study.repeat=0", "/study/repeat", "1 to 1000"),
        ("study.budget_seconds=-1", "/study/budget_seconds", "above 0"),
    ]);
}

/// A "step" dashpot without a fixed step is the fault of the missing step, not a second one.
#[test]
fn a_step_dashpot_needs_a_step() {
    refuses(&[("time.step=null;system.network.springs.0.dashpot={\"relative\":\"step\"}", "/time/step", "fixed step")]);
}

/// A pendulum has no springs for Kang's filter and one node for probes.
#[test]
fn pendulum() {
    let text = r#"{"name": "p", "system": {"pendulum": {"length": 1, "mass": 1, "gravity": 9.81, "angle": 1}},
                   "time": {"end": 1, "step": 0.1, "method": "rk4"}}"#;
    text_with(text, &[]).expect("a good pendulum");
    for (key, value, pointer, words) in [
        ("time.method", "kang", "/time/method", "springs of a network"),
        ("system.pendulum.length", "0", "/system/pendulum/length", "above 0"),
        ("system.pendulum.mass", "-1", "/system/pendulum/mass", "above 0"),
        ("system.pendulum.damping", "-1", "/system/pendulum/damping", "0 or more"),
        ("system.pendulum.length", "1e-200", "/system/pendulum", "range of a double"),
        ("output.probes", r#"[{"name": "a", "on": "outer"}]"#, "/output/probes/0/on", "one node"),
        ("output.probes", r#"[{"name": "a", "on": {"ids": [1]}}]"#, "/output/probes/0/on/ids/0", "from 0 to 0"),
    ] {
        let list = faults(text_with(text, &[(key, value)]));
        assert_eq!(list.len(), 1, "{list:#?}");
        assert_eq!(list[0].pointer, pointer);
        assert!(list[0].to_string().contains(words), "{}", list[0]);
    }
}

/// All faults of the second pass come at once, whatever section they are in.
#[test]
fn faults_of_all_sections_at_once() {
    let list = faults(base_with(&sets(
        "time.end=0;time.method=foo;system.network.springs.0.stiffness=-1;system.network.supports.0.fix=q;\
         solver.newton.relative=0;output.frames.every=0;system.network.mass.nodal=-1;study.repeat=0",
    )));
    let mut pointers: Vec<&str> = list.iter().map(|f| f.pointer.as_str()).collect();
    pointers.sort_unstable();
    assert_eq!(
        pointers,
        [
            "/output/frames/every",
            "/solver/newton/relative",
            "/study/repeat",
            "/system/network/mass/nodal",
            "/system/network/springs/0/stiffness",
            "/system/network/supports/0/fix",
            "/time/end",
            "/time/method",
        ]
    );
}

/// Gauges that measure nothing, and events outside the run.
#[test]
fn gauges_and_events() {
    refuses(&[
        (
            "output.gauges=[{\"name\":\"a\",\"on\":\"outer\",\"of\":\"tension\"}]",
            "/output/gauges/0/on",
            "a selection of edges",
        ),
        (
            "output.gauges=[{\"name\":\"a\",\"on\":\"lines\",\"of\":\"speed\"}]",
            "/output/gauges/0/on",
            "a selection of nodes",
        ),
        (
            "output.gauges=[{\"name\":\"a\",\"on\":{\"group\":\"riser\"},\"of\":\"tension\"}]",
            "/output/gauges/0/on/group",
            "this mesh has no groups",
        ),
        (
            "output.gauges=[{\"name\":\"a\",\"on\":{\"ids\":[5]},\"of\":\"force\"}]",
            "/output/gauges/0/on/ids/0",
            "from 0 to 4",
        ),
        ("output.gauges=[{\"name\":\"a\",\"on\":\"all\",\"of\":\"stresses\"}]", "/output/gauges/0/of", "tension"),
        ("output.gauges=[{\"name\":\"\",\"on\":\"all\",\"of\":\"speed\"}]", "/output/gauges/0/name", "1 to 200"),
        (
            "output.gauges=[{\"name\":\"a\",\"on\":\"all\",\"of\":\"speed\",\"every\":0}]",
            "/output/gauges/0/every",
            "1 or more",
        ),
        (
            "output.gauges=[{\"name\":\"a\",\"on\":\"all\",\"of\":\"speed\"},{\"name\":\"a\",\"on\":\"all\",\"of\":\"force\"}]",
            "/output/gauges/1/name",
            "no other gauge",
        ),
        ("system.network.springs.0.strength=0", "/system/network/springs/0/strength", "above 0"),
        ("system.network.springs.0.cut=-1", "/system/network/springs/0/cut", "above 0"),
        ("system.network.supports.0.until=0", "/system/network/supports/0/until", "above 0"),
    ]);
}

/// Motions of supports, bases, and rest lengths over time.
#[test]
fn motions() {
    refuses(&[
        ("system.network.supports.0.motion=[0,1]", "/system/network/supports/0/motion", "an object"),
        (
            "system.network.supports.0.motion={\"tabel\":[[0,0,0,0]]}",
            "/system/network/supports/0/motion/tabel",
            "did you mean \"table\"",
        ),
        (
            "system.network.supports.0.motion={\"table\":[]}",
            "/system/network/supports/0/motion/table",
            "at least one row",
        ),
        (
            "system.network.supports.0.motion={\"table\":[[0,0,0,0],[1,1,0,0],[1,2,0,0]]}",
            "/system/network/supports/0/motion/table/2",
            "strictly increasing",
        ),
        (
            "system.network.supports.0.motion={\"table\":[[0,1,0,0],[1,1,0,0]]}",
            "/system/network/supports/0/motion/table",
            "no displacement at t = 0",
        ),
        (
            "system.network.supports.0.fix=xy;system.network.supports.0.motion={\"table\":[[0,0,0,0],[1,0,0,2]]}",
            "/system/network/supports/0/motion/table/1/3",
            "0 in z, a direction that this support does not hold",
        ),
        (
            "system.network.supports=[{\"on\":{\"ids\":[0,1]},\"fix\":\"xyz\"},{\"on\":{\"ids\":[1]},\"fix\":\"z\",\"motion\":{\"table\":[[0,0,0,0],[1,0,0,1]]}}]",
            "/system/network/supports/1",
            "nodes 1 are held by supports[0] too",
        ),
        (
            "system.network.supports.0.motion={\"table\":[[0,0,0,0],[1,2,0,0]]};system.network.initial={\"velocity\":[[0,0,0],[0,0,0],[0,0,0],[0,0,0],[0,0,0]]}",
            "/system/network/initial/velocity/0",
            "2 m/s in x, the velocity of its support",
        ),
        (
            "system.network.base_acceleration={\"table\":[[0,0,0,0],[0,1,0,0]]}",
            "/system/network/base_acceleration/table/1",
            "strictly increasing",
        ),
        ("system.network.base_acceleration={\"table\":[[0,0,0]]}", "/system/network/base_acceleration/table/0", "4"),
        (
            "system.network.base_acceleration={\"table\":[[0,0,0,1]]};system.network.aero={\"wind\":[0,0,9],\"law\":{\"pressure_coefficient\":{\"cp\":1,\"air_density\":1.2}}}",
            "/system/network/base_acceleration",
            "only without aero",
        ),
        (
            "system.network.springs.0.rest_scale={\"table\":[]}",
            "/system/network/springs/0/rest_scale/table",
            "at least one row",
        ),
        (
            "system.network.springs.0.rest_scale={\"table\":[[0,1],[1,0]]}",
            "/system/network/springs/0/rest_scale/table/1/1",
            "above 0",
        ),
        (
            "system.network.springs.0.rest_scale={\"table\":[[1,1],[0,2]]}",
            "/system/network/springs/0/rest_scale/table/1",
            "strictly increasing",
        ),
        ("system.network.springs.0.rest_scale=short", "/system/network/springs/0/rest_scale", "a number"),
    ]);
}

/// Their values at the start are those of the tables, and what is right is accepted.
#[test]
fn motions_that_are_right() {
    let motion = r#"{"table":[[-1,-2,0,0],[1,2,0,0]]}"#;
    let velocity = r#"{"velocity":[[2,0,0],[0,0,0],[0,0,1],[0,0,0],[0,0,0]]}"#;
    let sets = [
        ("system.network.supports.0.motion", motion),
        ("system.network.initial", velocity),
        ("system.network.springs.0.rest_length", "0.5"),
        ("system.network.springs.0.rest_scale", r#"{"table":[[0,2],[1,1]]}"#),
        ("system.network.base_acceleration", r#"{"table":[[0,0,0,1]]}"#),
    ];
    base_with(&sets).expect("all of it is right");
}

/// A selection without another one leaves something and takes something away.
#[test]
fn except_takes_a_part() {
    refuses(&[
        (
            "system.network.supports.0.on={\"of\":\"all\",\"except\":\"all\"}",
            "/system/network/supports/0/on",
            "has all 5 nodes",
        ),
        (
            "system.network.supports.0.on={\"of\":{\"ids\":[0]},\"except\":{\"ids\":[1]}}",
            "/system/network/supports/0/on/except",
            "no node of",
        ),
        (
            "system.network.supports.0.on={\"of\":\"al\",\"except\":{\"ids\":[1]}}",
            "/system/network/supports/0/on/of",
            "did you mean \"all\"",
        ),
        (
            "system.network.supports.0.on={\"of\":\"all\",\"except\":{\"group\":\"gate\"}}",
            "/system/network/supports/0/on/except/group",
            "no groups",
        ),
        (
            "system.network.springs.0.on={\"of\":\"lines\",\"except\":\"all\"}",
            "/system/network/springs/0/on",
            "has all 1 edges",
        ),
        ("system.network.springs.0.on={\"of\":\"all\"}", "/system/network/springs/0/on/of", "known names here"),
    ]);
}
