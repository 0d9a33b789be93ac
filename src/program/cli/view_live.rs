//! A server on 127.0.0.1 for the page of a run that goes on: the page, and the frames since those that it has.
//!
//! It answers one question after the other, with a limit for the size of each and the time for it, and stops at the
//! first signal. Only questions that name this machine as their host are answered: else a page from elsewhere could
//! read results through a name of its own that leads here.

use super::CliError;
use super::interrupt::{is_asked, stop_on_interrupt};
use super::terminal::print;
use crate::plot::PlotError;
use crate::study::StudyError;
use crate::study::view::{Recording, page, part};
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::Path;
use std::time::{Duration, Instant};

/// [byte] Longest question.
const LONGEST: usize = 8192;
/// How long the other side may take to ask, and each time to take more of an answer.
const PATIENCE: Duration = Duration::from_secs(5);
/// Time between two looks for questions and signals.
const PAUSE: Duration = Duration::from_millis(20);
/// In place of a page while there are no frames.
const WAITING: &str = "<!DOCTYPE html><meta charset=\"utf-8\"><meta http-equiv=\"refresh\" content=\"1\"><title>canopy-fem</title>\
                       <p>There are no frames yet; this page looks again every second.</p>";

/// Answers until a signal comes. The page looks into the folder of the run anew for each answer.
pub(super) fn serve(run: &Path, port: u16) -> Result<(), CliError> {
    if !run.is_dir() {
        return Err(PlotError::NoFolder(run.to_owned()).into());
    }
    let system = |source| PlotError::System { path: format!("127.0.0.1:{port}").into(), source };
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(system)?;
    listener.set_nonblocking(true).map_err(system)?;
    let at = listener.local_addr().map_err(system)?;
    stop_on_interrupt();
    let _ = print(&format!("http://{at}/ shows {} while it grows; Ctrl-C ends it\n", run.display()));
    while !is_asked() {
        match listener.accept() {
            // What goes wrong with one question is the asker's to see.
            Ok((mut stream, _)) => drop(answer(&mut stream, run)),
            Err(e) if e.kind() == ErrorKind::WouldBlock => std::thread::sleep(PAUSE),
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(e) => return Err(system(e).into()),
        }
    }
    Ok(())
}

fn answer(stream: &mut TcpStream, run: &Path) -> io::Result<()> {
    stream.set_nonblocking(false)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let head = question(stream)?;
    let (status, kind, body) = reply(&head, run);
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}; charset=utf-8\r\nContent-Length: {}\r\n\
         Cache-Control: no-store\r\nConnection: close\r\n\r\n",
        body.len()
    )?;
    stream.write_all(body.as_bytes())
}

/// The lines of a question down to the empty one.
fn question(stream: &mut TcpStream) -> io::Result<String> {
    let (mut head, mut buffer, began) = (Vec::new(), [0; 1024], Instant::now());
    while !head.windows(4).any(|end| end == b"\r\n\r\n") {
        let count = stream.read(&mut buffer)?;
        head.extend_from_slice(&buffer[..count]);
        if count == 0 || head.len() > LONGEST || began.elapsed() > PATIENCE {
            return Err(ErrorKind::InvalidData.into());
        }
    }
    Ok(String::from_utf8_lossy(&head).into_owned())
}

/// Status, kind and text of the answer.
fn reply(head: &str, run: &Path) -> (&'static str, &'static str, String) {
    let mut lines = head.split("\r\n");
    let mut words = lines.next().unwrap_or_default().split(' ');
    let (method, target) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    let fields = lines.filter_map(|line| line.split_once(':'));
    let host = fields.filter(|(name, _)| name.eq_ignore_ascii_case("host")).map(|(_, host)| host.trim()).next();
    let name = host.and_then(|host| host.split(':').next());
    if !matches!(name, Some("127.0.0.1" | "localhost")) {
        return ("403 Forbidden", "text/plain", "ask for 127.0.0.1\n".to_owned());
    }
    if method != "GET" {
        return ("405 Method Not Allowed", "text/plain", "only GET is answered\n".to_owned());
    }
    let open = || Recording::open(run).map_err(StudyError::from);
    let from = target.strip_prefix("/part?from=").and_then(|number| number.parse().ok());
    match (target, from) {
        ("/", _) => match open().and_then(|recording| page(&[recording], true)) {
            Ok((text, _)) => ("200 OK", "text/html", text),
            Err(StudyError::Plot(PlotError::NotThere(_))) => ("200 OK", "text/html", WAITING.to_owned()),
            Err(error) => ("500 Internal Server Error", "text/plain", format!("{error}\n")),
        },
        (_, Some(from)) => match open().and_then(|recording| part(&recording, from)) {
            Ok(text) => ("200 OK", "application/json", text),
            Err(error) => ("500 Internal Server Error", "text/plain", format!("{error}\n")),
        },
        _ => ("404 Not Found", "text/plain", "there are / and /part?from=N\n".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Other hosts, other methods and other places are refused.
    #[test]
    fn what_is_refused() {
        let status = |head: &str| reply(head, Path::new("no/such/folder")).0;
        assert_eq!(status("GET / HTTP/1.1\r\nHost: example.com\r\n\r\n"), "403 Forbidden");
        assert_eq!(status("GET / HTTP/1.1\r\n\r\n"), "403 Forbidden");
        assert_eq!(status("POST / HTTP/1.1\r\nhost: localhost:80\r\n\r\n"), "405 Method Not Allowed");
        assert_eq!(status("GET /../secret HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"), "404 Not Found");
        assert_eq!(status("GET /part?from=x HTTP/1.1\r\nHost: 127.0.0.1:8000\r\n\r\n"), "404 Not Found");
        assert_eq!(status("GET / HTTP/1.1\r\nHost: 127.0.0.1:8000\r\n\r\n"), "500 Internal Server Error");
    }
}
