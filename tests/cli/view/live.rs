//! A page that is served while its run goes on.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::bench;

/// A server that ends with the test.
struct Server(Child);

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Status line and body of an answer.
fn ask(address: &str, target: &str) -> (String, String) {
    let mut stream = TcpStream::connect(address).expect("the server listens");
    stream.set_read_timeout(Some(Duration::from_secs(60))).expect("set");
    write!(stream, "GET {target} HTTP/1.1\r\nHost: {address}\r\n\r\n").expect("sent");
    let mut text = String::new();
    stream.read_to_string(&mut text).expect("an answer");
    let (head, body) = text.split_once("\r\n\r\n").expect("a head");
    (head.lines().next().expect("a status").to_owned(), body.to_owned())
}

/// The page comes before the run has ended, later frames come as parts, and a signal ends the server with status 0.
#[test]
fn a_run_that_goes_on() {
    let bench = bench();
    assert_eq!(bench.solve(&[]).code, Some(0));
    let summary = bench.path("out/summary.json");
    std::fs::rename(&summary, bench.path("kept.json")).expect("moved");
    let list = std::fs::read_to_string(bench.path("out/sail.pvd")).expect("a list");
    let begun: String = list
        .lines()
        .filter(|line| !line.contains("_00001") && !line.contains("_000009"))
        .map(|l| l.to_owned() + "\n")
        .collect();
    std::fs::write(bench.path("out/sail.pvd"), begun).expect("written");
    let mut command = bench.program();
    command.args(["view", "out", "--live"]).stdout(Stdio::piped());
    let mut server = Server(command.spawn().expect("the program starts"));
    let mut line = String::new();
    BufReader::new(server.0.stdout.take().expect("piped")).read_line(&mut line).expect("a line");
    let address = line.strip_prefix("http://").and_then(|rest| rest.split('/').next()).expect("an address").to_owned();
    assert!(address.starts_with("127.0.0.1:"), "{line}");
    let (status, page) = ask(&address, "/");
    assert_eq!(status, "HTTP/1.1 200 OK");
    assert!(page.contains("const live = true;"));
    let run = super::data::runs(&page).remove(0);
    assert_eq!(
        (super::data::frame_count(&run), &run["part"]["next"], &run["part"]["status"]),
        (9, &Value::from(9), &Value::from(""))
    );
    std::fs::write(bench.path("out/sail.pvd"), list).expect("written");
    std::fs::rename(bench.path("kept.json"), &summary).expect("moved");
    let (status, part) = ask(&address, "/part?from=9");
    assert_eq!(status, "HTTP/1.1 200 OK");
    let part: Value = serde_json::from_str(&part).expect("JSON");
    assert_eq!(part["frames"].as_array().expect("frames").len(), 2);
    assert_eq!(
        (&part["next"], &part["listed"], &part["status"]),
        (&Value::from(11), &Value::from(11), &Value::from("completed"))
    );
    assert_eq!(ask(&address, "/summary.json").0, "HTTP/1.1 404 Not Found");
    // One that asks for nothing keeps the others waiting for five seconds at most.
    let idle = TcpStream::connect(&address).expect("the server listens");
    let began = Instant::now();
    assert_eq!(ask(&address, "/part?from=11").0, "HTTP/1.1 200 OK");
    assert!(began.elapsed() < Duration::from_secs(30));
    drop(idle);
    #[cfg(unix)]
    {
        let id = server.0.id().to_string();
        assert!(std::process::Command::new("kill").args(["-INT", &id]).status().expect("kill").success());
        assert_eq!(server.0.wait().expect("it ends").code(), Some(0));
    }
}
