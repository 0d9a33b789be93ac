//! The background thread that writes results, and the bounded channel to it.

use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;

use super::checkpoint::Checkpoint;
use super::crossings::{CrossingReport, CrossingWatch};
use super::csv::LONGEST_DELAY;
use super::files::{FilesProgress, FilesSpec, ResultFiles};
use super::frame::{Frame, FrameSize};
use super::gauges::GaugeRow;
use super::resume::ResumeError;
use super::rows::HistoryRow;
use crate::drive::observer::ObserveError;

/// Largest number of frames that exist, if they are small: waiting for the other thread, or waking it, at every frame
/// costs more than a quick step.
const MOST: usize = 128;
/// Fewest frames: one being filled, one being written, one in between.
const FEWEST: usize = 3;
/// [byte] memory that frames beyond the fewest may take
const ROOM: usize = 8 << 20;
/// Number of messages that may wait. With a full channel the integrator waits, so memory is bounded on a slow disk.
const WAITING: usize = 256;
/// After a message the thread checks for the next one after this time, before it sleeps until it is woken: to wake it
/// for every row costs both threads more than a quick step.
const NAP: Duration = Duration::from_micros(500);
/// Largest number of checkpoints that exist, each as large as the state: one being written, one waiting.
const CHECKPOINTS: usize = 2;

/// Number of frames of a size that may exist: filled, waiting, or to be filled again.
pub fn most_frames(size: FrameSize) -> usize {
    (ROOM / size.bytes().max(1)).clamp(FEWEST, MOST)
}

/// A message to the thread. It ends when the channel is closed.
pub(super) enum Message {
    /// a filled frame
    Frame(Frame),
    /// a row of the history
    Row(HistoryRow),
    /// a value of a gauge
    Gauge(GaugeRow),
    /// \[s\] the frames after this time are to be removed
    WithdrawAfter(f64),
    /// to be written after everything sent before it; see [`ResultWriter::checkpoint`]
    Checkpoint(Box<Checkpoint>),
}

/// The thread's ends of the channels.
struct WriterChannels {
    messages: Receiver<Message>,
    give_back: SyncSender<Frame>,
    /// frames not yet returned
    written: Vec<Frame>,
    /// largest number of frames
    most: usize,
    kept: SyncSender<()>,
}

/// How the thread ended, and what it found of crossings if it searched for them.
type WriterEnd = (Result<(), ObserveError>, Option<CrossingReport>);

/// The integrator's end of the channels. When it is dropped, the thread writes all that was sent and is joined.
#[derive(Debug)]
pub struct ResultWriter {
    to_thread: Option<SyncSender<Message>>,
    returned: Receiver<Frame>,
    /// receives a message for every written checkpoint
    kept: Receiver<()>,
    /// checkpoints sent and not yet known to be written
    unkept: usize,
    thread: Option<JoinHandle<WriterEnd>>,
    /// what the thread has found, once it has ended
    crossings: Option<CrossingReport>,
    size: FrameSize,
    made: usize,
    /// a frame that was filled but not sent
    spare: Option<Frame>,
}

impl ResultWriter {
    /// Creates the files and starts the thread, which searches frames with `watch` before it writes them.
    ///
    /// # Errors
    /// When a file cannot be created or the thread cannot be started.
    pub(super) fn start(spec: &FilesSpec<'_>, watch: Option<CrossingWatch>) -> Result<Self, ObserveError> {
        Self::spawn(ResultFiles::create(spec)?, spec, watch)
    }

    /// Reopens the files of an earlier run, cuts them off at `mark`, and starts the thread.
    ///
    /// # Errors
    /// When the files cannot be reopened, or the thread cannot be started.
    pub(super) fn resume(
        spec: &FilesSpec<'_>,
        mark: &FilesProgress,
        watch: Option<CrossingWatch>,
    ) -> Result<Self, ResumeError> {
        Ok(Self::spawn(ResultFiles::reopen(spec, mark)?, spec, watch)?)
    }

    fn spawn(files: ResultFiles, spec: &FilesSpec<'_>, watch: Option<CrossingWatch>) -> Result<Self, ObserveError> {
        let size = spec.frame_size();
        let most = most_frames(size);
        let (to_thread, messages) = sync_channel(WAITING);
        let (give_back, returned) = sync_channel(most);
        let (tell_kept, kept) = sync_channel(CHECKPOINTS);
        let ends = WriterChannels { messages, give_back, written: Vec::with_capacity(most), most, kept: tell_kept };
        let thread = std::thread::Builder::new()
            .name("results".to_owned())
            .spawn(move || write_all(files, ends, watch))
            .map_err(|source| ObserveError::Write { path: spec.folder.display().to_string(), source })?;
        let (to_thread, thread) = (Some(to_thread), Some(thread));
        Ok(Self { to_thread, returned, kept, unkept: 0, thread, crossings: None, size, made: 0, spare: None })
    }

    /// A frame to fill: a used one if available, a new one for the first few, else the next that is returned. It still
    /// has its old content.
    pub fn empty_frame(&mut self) -> Result<Frame, ObserveError> {
        if let Some(frame) = self.spare.take() {
            return Ok(frame);
        }
        match self.returned.try_recv() {
            Ok(frame) => return Ok(frame),
            Err(TryRecvError::Disconnected) => return Err(self.fault()),
            Err(TryRecvError::Empty) => {}
        }
        if self.made < most_frames(self.size) {
            self.made += 1;
            return Ok(Frame::new(self.size));
        }
        match self.returned.recv() {
            Ok(frame) => Ok(frame),
            Err(_) => Err(self.fault()),
        }
    }

    /// Takes back a frame that will not be written.
    pub fn recycle(&mut self, frame: Frame) {
        self.spare = Some(frame);
    }

    /// Sends a checkpoint, to be written after everything sent before it. Waits while too many are not yet written.
    pub fn checkpoint(&mut self, checkpoint: Box<Checkpoint>) -> Result<(), ObserveError> {
        self.unkept -= self.kept.try_iter().count().min(self.unkept);
        if self.unkept == CHECKPOINTS {
            self.kept.recv().map_err(|_| self.fault())?;
            self.unkept -= 1;
        }
        self.unkept += 1;
        self.send(Message::Checkpoint(checkpoint))
    }

    /// Waits until everything is passed to the system.
    ///
    /// # Errors
    /// The error that ended the thread; after it was reported once, [`ObserveError::WriterGone`].
    pub fn finish(&mut self) -> Result<(), ObserveError> {
        self.to_thread = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok((result, crossings))) => {
                self.crossings = crossings;
                result
            }
            Some(Err(_)) | None => Err(ObserveError::WriterGone),
        }
    }

    /// What the thread has found of crossings, once it has ended.
    pub(super) fn crossings(&self) -> Option<&CrossingReport> {
        self.crossings.as_ref()
    }

    /// Sends a message.
    pub(super) fn send(&mut self, message: Message) -> Result<(), ObserveError> {
        let sent = self.to_thread.as_ref().is_some_and(|channel| channel.send(message).is_ok());
        if sent { Ok(()) } else { Err(self.fault()) }
    }

    /// The error that ended the thread.
    fn fault(&mut self) -> ObserveError {
        self.finish().err().unwrap_or(ObserveError::WriterGone)
    }
}

impl Drop for ResultWriter {
    fn drop(&mut self) {
        // An error cannot be reported here; a run that wants to know calls `finish`.
        let _ = self.finish();
    }
}

impl WriterChannels {
    /// The next message, if one comes in time; called after a message.
    fn next(&mut self) -> Result<Message, RecvTimeoutError> {
        match self.messages.try_recv() {
            Ok(message) => return Ok(message),
            Err(TryRecvError::Disconnected) => return Err(RecvTimeoutError::Disconnected),
            Err(TryRecvError::Empty) => {}
        }
        // An integrator that waits for a frame sends nothing meanwhile.
        self.give_back();
        std::thread::sleep(NAP);
        self.messages.recv_timeout(LONGEST_DELAY)
    }

    /// Returns a written frame. Frames are returned in groups of half of all (of three, one by one), so that an
    /// integrator that waits for the disk is not woken for each frame.
    fn written(&mut self, frame: Frame) {
        self.written.push(frame);
        if self.written.len() >= self.most / 2 {
            self.give_back();
        }
    }

    fn give_back(&mut self) {
        for frame in self.written.drain(..) {
            // Never full: no more frames exist than fit. If the channel is closed, the run is over.
            let _ = self.give_back.try_send(frame);
        }
    }
}

/// The thread: ends when the channel is closed or at the first error, and then saves what it can.
fn write_all(mut files: ResultFiles, mut ends: WriterChannels, mut watch: Option<CrossingWatch>) -> WriterEnd {
    let ended = listen(&mut files, &mut ends, watch.as_mut());
    // All files are tried; the first error is reported.
    (ended.and(files.finish()), watch.map(|watch| watch.report().clone()))
}

fn listen(
    files: &mut ResultFiles,
    ends: &mut WriterChannels,
    mut watch: Option<&mut CrossingWatch>,
) -> Result<(), ObserveError> {
    loop {
        match ends.next() {
            Ok(Message::Frame(mut frame)) => {
                if let Some(watch) = &mut watch {
                    watch.frame(&mut frame);
                }
                files.frame(&frame)?;
                ends.written(frame);
            }
            Ok(Message::Row(row)) => files.row(&row)?,
            Ok(Message::Gauge(row)) => files.gauge(&row)?,
            Ok(Message::WithdrawAfter(t)) => files.withdraw_after(t)?,
            Ok(Message::Checkpoint(mut checkpoint)) => {
                if let Some(watch) = &watch {
                    checkpoint.recorder.crossings = Some(watch.report().clone());
                }
                files.checkpoint(*checkpoint)?;
                let _ = ends.kept.try_send(());
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(()),
        }
        files.flush_if_due()?;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Groups;
    use crate::output::frame::Fields;
    use crate::output::frame_files::frames_in;
    use crate::vtk::VtuFormat;

    /// Sends `frames` frames of `nodes` nodes as fast as they are written; returns how many existed.
    fn frames_made(nodes: usize, frames: usize) -> usize {
        let dir = tempfile::tempdir().expect("a folder");
        let spec = FilesSpec {
            folder: dir.path().to_owned(),
            stem: "net".to_owned(),
            reference: &vec![[0.0; 3]; nodes],
            triangles: &[],
            edges: &[],
            groups: &Groups::new(),
            fields: Fields::default(),
            draw_sides: false,
            probes: &[],
            gauges: Vec::new(),
            format: VtuFormat::default(),
        };
        let mut writer = ResultWriter::start(&spec, None).expect("a writer");
        for i in 0..frames {
            let mut frame = writer.empty_frame().expect("a frame");
            (frame.time, frame.positions[0][0]) = (i as f64, i as f64);
            writer.send(Message::Frame(frame)).expect("a thread that listens");
        }
        writer.finish().expect("all is written");
        let files = frames_in(&dir.path().join("frames"), "net").expect("a folder");
        assert_eq!(files.len(), frames);
        for (i, file) in files.iter().enumerate() {
            let bytes = std::fs::read(file).expect("a frame");
            let time = format!(">{:?}</DataArray>", i as f64);
            assert!(bytes.windows(time.len()).any(|w| w == time.as_bytes()), "frame {i}");
        }
        writer.made
    }

    /// An integrator that is quicker than the disk gets old frames and loses none; of large scenes as few exist as
    /// possible.
    #[test]
    fn frames_are_used_again() {
        assert!((1..=MOST).contains(&frames_made(10, 4 * MOST)));
        let nodes = ROOM / (FEWEST * 48) + 1;
        assert!((1..=FEWEST).contains(&frames_made(nodes, 3 * FEWEST)));
    }
}
