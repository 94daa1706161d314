// A client of hapticd for Unity and every .NET that has .NET Standard 2.0: copy it into Assets/,
// and with it DeviceState.cs and HapticPlane.cs, which are made of the messages when hapticd is
// built. It speaks haptic.v1.proto on a WebSocket (server { web {} } in the scene), so numbers
// arrive bit for bit. Field numbers of other messages are those of proto/haptic/v1/session.proto.
//
// Nothing here blocks. Sockets live on the thread pool; every member may be called from any thread,
// Unity's main thread for instance. Units are SI. An array has one value per degree of freedom or
// per virtual coordinate, in the order that `hapticctl info` shows.
using System;
using System.Collections.Concurrent;
using System.Collections.Generic;
using System.Diagnostics;
using System.Net.Http;
using System.Net.Http.Headers;
using System.Net.WebSockets;
using System.Text;
using System.Text.RegularExpressions;
using System.Threading;
using System.Threading.Tasks;

namespace Haptic {

public sealed class SessionOptions {
  public Uri Server = new Uri("http://127.0.0.1:29473");  // or https
  public string Token = "";   // one of the scene's server.web.token
  public string Device = "";  // its name; empty: the only one of the server
  public string ClientName = "Unity";  // shown to other clients; 1 to 64 bytes
  public bool Observer;                // receives states, publishes nothing
  public double NominalRateHz = 60;    // how often you will publish, 1 to 2000
  public double StateRateHz;           // states per second; 0: every tick
  public TimeSpan Timeout = TimeSpan.FromSeconds(5);  // of the opening, and of each call
}

/// Reason is the server's stable word ("LEASE_HELD"), or "" if none came.
public sealed class HapticException : Exception {
  public readonly string Reason;
  public HapticException(string reason, string message) : base(message) { Reason = reason; }
}

/// A session with one device. It opens in the background; Dispose() ends it, and the server then
/// lets the force fade out. One that ended stays ended: make another.
public sealed partial class HapticSession : IDisposable {
  const int LargestMessage = 65536, MostEvents = 256, MostPlanes = 32;
  static readonly TimeSpan Silence = TimeSpan.FromSeconds(2.5);
  static readonly HttpClient Http = new HttpClient {
      Timeout = Timeout.InfiniteTimeSpan, MaxResponseContentBufferSize = LargestMessage};

  readonly SessionOptions options_;
  readonly CancellationTokenSource life_ = new CancellationTokenSource();
  readonly TaskCompletionSource<string> opened_ =  // the session's id
      new TaskCompletionSource<string>(TaskCreationOptions.RunContinuationsAsynchronously);
  readonly ConcurrentQueue<HapticEvent> events_ = new ConcurrentQueue<HapticEvent>();
  readonly SemaphoreSlim toSend_ = new SemaphoreSlim(0);
  readonly object lock_ = new object();  // of what follows
  DeviceState newest_, given_;
  byte[] next_;  // the newest sample, until it is sent
  ulong published_, conflated_, accepted_;
  string rejection_ = "";
  bool leaving_;
  int silent_;  // spans of Silence since the last message; by Interlocked
  int wish_;  // rises with everything that ends EngageWhenReady()
  Task engaging_ = Task.CompletedTask;  // its newest call

  public HapticSession(SessionOptions options) {
    options_ = options ?? throw new ArgumentNullException(nameof(options));
    Ended = Task.Run(Run);
  }

  /// Completes when the server agreed; fails with a HapticException if it did not.
  public Task Opened => opened_.Task;
  /// Completes when the session is over; Failure then says why, null: it was Dispose().
  public Task Ended { get; }
  public HapticException Failure { get; private set; }
  public bool Connected => opened_.Task.Status == TaskStatus.RanToCompletion && !Ended.IsCompleted;
  /// The newest state; null before the first one. The next sample is taken to be computed from it.
  public DeviceState State { get { lock (lock_) return given_ = newest_; } }
  public ulong Published { get { lock (lock_) return published_; } }
  /// Samples that gave way to a newer one before they could be sent.
  public ulong Conflated { get { lock (lock_) return conflated_; } }
  /// Samples that the server accepted, and why it refused the last one that it refused.
  public ulong Accepted { get { lock (lock_) return accepted_; } }
  public string LastRejection { get { lock (lock_) return rejection_; } }
  /// Why EngageWhenReady() has no force yet.
  public string EngageRefusal { get; private set; } = "";
  /// Events since this was last asked; of more than 256 the oldest are gone.
  public bool TryNextEvent(out HapticEvent next) => events_.TryDequeue(out next);

  /// Nothing is in the way: no force. Force begins with a held proxy only after a free one.
  public void PublishFree() => Publish(Mode.Free, null, null);
  /// Stays at x; where x is State.XProbe it follows the probe, unless the sample before held it so.
  public void PublishHeld(double[] x) => Publish(Mode.Held, Finite(x, nameof(x)), null);
  /// The server keeps the probe out of up to 32 planes or contacts at 1 kHz. x: where they are
  /// linearised; with an Id in any of them, the simulation's own proxy.
  public void PublishContacts(IReadOnlyList<HapticPlane> planes, double[] x) {
    if (planes == null) throw new ArgumentNullException(nameof(planes));
    if (planes.Count > MostPlanes) throw new ArgumentException("more than 32", nameof(planes));
    Publish(Mode.Planes, Finite(x, nameof(x)), planes);
  }

  /// Asks for force once. The task fails with a HapticException that says what is missing.
  public Task Engage() => Seen(Task.Run(() => CallForSession("Engage")));
  /// Asks every 50 ms until the server agrees. A fault, Release() and a refusal that waiting does
  /// not cure end it: the task then fails. Force that was lost later is not asked for again.
  public Task EngageWhenReady() {
    int wish;
    lock (lock_) wish = ++wish_;
    return Seen(Task.Run(() => EngageUntil(wish)));
  }
  /// Gives force up; it fades out.
  public Task Release() {
    Task engaging;
    lock (lock_) (wish_, engaging) = (wish_ + 1, engaging_);
    return Seen(Task.Run(async () => {
      await Task.WhenAny(engaging).ConfigureAwait(false);  // it must not overtake the Release
      await CallForSession("Release").ConfigureAwait(false);
    }));
  }
  /// Zero force now, latched as a fault, of the session's device, or of all of them if the options
  /// name none. Needs no open session.
  public Task EmergencyStop(string reason) {
    lock (lock_) ++wish_;
    byte[] stop = new Message().Text(1, options_.Device).Text(2, reason ?? "").Bytes();
    return Seen(Task.Run(() => Call("EmergencyStop", stop)));
  }
  /// Returns at once; the farewell goes out in the background, within 500 ms: a program that ends
  /// waits for Ended.
  public void Dispose() {
    lock (lock_) {
      if (leaving_) return;
      leaving_ = true;
      ++wish_;
    }
    if (!Ended.IsCompleted) life_.CancelAfter(500);
    toSend_.Release();
  }

  async Task Run() {
    HapticException why = null;
    try {
      using (var socket = new ClientWebSocket()) await Live(socket).ConfigureAwait(false);
    } catch (HapticException error) {
      why = error;
    } catch (Exception error) {  // sockets, names, cancellation, a message that cannot be read
      bool cut = life_.IsCancellationRequested;
      why = cut && !opened_.Task.IsCompleted ? NoAnswer() : new HapticException(
          "", cut ? "the server fell silent" : error.GetBaseException().Message);
    }
    lock (lock_) {
      ++wish_;
      Failure = leaving_ ? null : why;
      leaving_ = true;
    }
    life_.Cancel();
    opened_.TrySetException(why ?? new HapticException("", "the session ended"));
    _ = Seen(opened_.Task);
  }

  /// No caller has to wait for this task, so its exception must not count as forgotten.
  static Task Seen(Task task) {
    task.ContinueWith(done => done.Exception, TaskContinuationOptions.OnlyOnFaulted);
    return task;
  }

  async Task Live(ClientWebSocket socket) {
    socket.Options.AddSubProtocol("haptic.v1.proto");
    if (options_.Token != "") {
      socket.Options.SetRequestHeader("Authorization", "Bearer " + options_.Token);
    }
    byte[] open = new Message().Sub(1, new Message()
        .Text(1, options_.Device).Number(2, options_.Observer ? 2UL : 1UL)
        .Text(3, options_.ClientName).Real(4, options_.NominalRateHz)
        .Real(5, options_.StateRateHz)).Bytes();
    using (life_.Token.Register(socket.Abort))
    using (var late = new Timer(_ => { if (!opened_.Task.IsCompleted) life_.Cancel(); }, null,
                                options_.Timeout, Timeout.InfiniteTimeSpan))
    using (var watch = new Timer(_ => {  // states come at least once a second
      if (Interlocked.Increment(ref silent_) > 1 && opened_.Task.IsCompleted) life_.Cancel();
    }, null, Silence, Silence)) {
      try {
        await socket.ConnectAsync(Address("ws", "Session"), life_.Token).ConfigureAwait(false);
      } catch (WebSocketException) when (!life_.IsCancellationRequested) {  // by HTTP it says why
        await Call("GetServerInfo", new byte[0]).ConfigureAwait(false);
        throw;
      }
      await Send(socket, open).ConfigureAwait(false);
      // Who ends first ends the other: a session that cannot send must not look alive.
      Task sending = SendSamples(socket), receiving = Receive(socket);
      await Task.WhenAny(Seen(sending), Seen(receiving)).ConfigureAwait(false);
      if (sending.IsFaulted && !receiving.IsCompleted) await sending.ConfigureAwait(false);
      await receiving.ConfigureAwait(false);
    }
  }

  Task Send(ClientWebSocket socket, byte[] message) => socket.SendAsync(
      new ArraySegment<byte>(message), WebSocketMessageType.Binary, true, life_.Token);

  async Task SendSamples(ClientWebSocket socket) {
    await opened_.Task.ConfigureAwait(false);
    for (;;) {
      await toSend_.WaitAsync(life_.Token).ConfigureAwait(false);
      byte[] sample;
      bool leaving;
      lock (lock_) {
        sample = next_;
        next_ = null;
        leaving = leaving_;
      }
      if (sample != null) await Send(socket, sample).ConfigureAwait(false);
      if (!leaving) continue;
      await Send(socket, new Message().Sub(3, new Message()).Bytes()).ConfigureAwait(false);
      return;  // the server closes
    }
  }

  async Task Receive(ClientWebSocket socket) {
    var buffer = new byte[LargestMessage];
    for (int length = 0;;) {
      var room = new ArraySegment<byte>(buffer, length, buffer.Length - length);
      WebSocketReceiveResult got =
          await socket.ReceiveAsync(room, life_.Token).ConfigureAwait(false);
      if (got.MessageType == WebSocketMessageType.Close) {
        string[] said = (got.CloseStatusDescription ?? "").Split(new[] {": "}, 2,
                                                                 StringSplitOptions.None);
        throw said.Length == 2 ? new HapticException(said[0], said[1])
                               : new HapticException("", "the server ended the session");
      }
      length += got.Count;
      if (got.EndOfMessage) {
        Interlocked.Exchange(ref silent_, 0);
        Take(new Reader(buffer, 0, length));
        length = 0;
      } else if (length == buffer.Length) {
        throw new HapticException("", "a message of more than 64 KB");
      }
    }
  }

  void Take(Reader message) {
    while (message.Next()) {
      if (message.Field > 4) {  // of a newer protocol, or keys of a path that this does not use
        message.Skip();
        continue;
      }
      Reader inner = message.Sub();
      if (message.Field == 1) {
        string id = "";
        while (inner.Next()) if (inner.Field == 9) id = inner.Text(); else inner.Skip();
        opened_.TrySetResult(id);
      } else if (message.Field == 2) {
        DeviceState state = Of(inner, new DeviceState());
        state.Arrived = Clock();
        lock (lock_) newest_ = state;
      } else if (message.Field == 3) {
        HapticEvent told = Of(inner, new HapticEvent());
        if (told.Kind == Kind.Fault) lock (lock_) ++wish_;  // clearing it must not start a motor
        HapticEvent oldest;
        if (events_.Count >= MostEvents) events_.TryDequeue(out oldest);
        events_.Enqueue(told);
      } else if (message.Field == 4) {
        lock (lock_) {
          while (inner.Next()) {
            if (inner.Field == 2) accepted_ = inner.Number();
            else if (inner.Field == 6) rejection_ = inner.Text();
            else inner.Skip();
          }
        }
      }
    }
  }

  void Publish(Mode mode, double[] x, IReadOnlyList<HapticPlane> planes) {
    lock (lock_) {
      if (leaving_) return;
      long now = Clock();
      Message sample = new Message().Number(1, ++published_).Number(2, (ulong)now);
      if (given_ != null) {
        sample.Number(3, given_.Seq).Number(4, (ulong)Math.Min((now - given_.Arrived) / 1000,
                                                                uint.MaxValue));
      }
      sample.Reals(6, x).Number(8, (ulong)mode);
      foreach (HapticPlane plane in planes ?? new HapticPlane[0]) {
        sample.Sub(10, Of(plane));
      }
      byte[] bytes = new Message().Sub(2, sample).Bytes();
      if (bytes.Length > LargestMessage) throw new ArgumentException("more than 64 KB");
      if (next_ != null) ++conflated_;
      else toSend_.Release();
      next_ = bytes;
    }
  }

  async Task EngageUntil(int wish) {
    for (;;) {
      Task engaging;
      lock (lock_) {
        if (wish != wish_) throw new HapticException("", "force is not asked for any more");
        if (newest_ != null && newest_.State == Lifecycle.Fault) {
          throw new HapticException("FAULT", "the device is in FAULT");
        }
        engaging_ = engaging = Task.Run(() => CallForSession("Engage"));
      }
      try {
        await engaging.ConfigureAwait(false);
        EngageRefusal = "";
        return;
      } catch (HapticException why) {
        EngageRefusal = why.Message;
        if (!Curable.Contains(why.Reason)) throw;
      }
      await Task.Delay(50, life_.Token).ConfigureAwait(false);
    }
  }

  async Task CallForSession(string method) {
    string id = await opened_.Task.ConfigureAwait(false);
    await Call(method, new Message().Text(1, id).Bytes()).ConfigureAwait(false);
  }

  async Task Call(string method, byte[] body) {
    using (var request = new HttpRequestMessage(HttpMethod.Post, Address("http", method))) {
      request.Content = new ByteArrayContent(body);
      request.Content.Headers.ContentType = new MediaTypeHeaderValue("application/proto");
      request.Headers.ExpectContinue = false;
      if (options_.Token != "") {
        request.Headers.Authorization = new AuthenticationHeaderValue("Bearer", options_.Token);
      }
      try {
        using (var late = new CancellationTokenSource(options_.Timeout))
        using (HttpResponseMessage answer =
                   await Http.SendAsync(request, late.Token).ConfigureAwait(false)) {
          if (answer.IsSuccessStatusCode) return;
          string text = await answer.Content.ReadAsStringAsync().ConfigureAwait(false);
          string message = Said(text, "message");
          throw new HapticException(Said(text, "reason"),
                                    message != "" ? message : "HTTP " + (int)answer.StatusCode);
        }
      } catch (OperationCanceledException) {
        throw NoAnswer();
      } catch (Exception error) when (!(error is HapticException)) {
        throw new HapticException("", error.GetBaseException().Message);
      }
    }
  }

  HapticException NoAnswer() =>
      new HapticException("", "no answer in " + options_.Timeout.TotalSeconds + " s");

  /// The first string of this name in the JSON of an error; empty if there is none.
  static string Said(string json, string name) {
    string said = Regex.Match(
        json, "\"" + name + "\":\\s*\"((?:[^\"\\\\]|\\\\.)*)\"").Groups[1].Value;
    try {
      return Regex.Unescape(said);
    } catch (ArgumentException) {  // not JSON's
      return said;
    }
  }

  Uri Address(string scheme, string method) => new UriBuilder(options_.Server) {
      Scheme = scheme + (options_.Server.Scheme == "https" ? "s" : ""),
      Path = "/haptic.v1.HapticService/" + method}.Uri;

  /// A steady clock, ns.
  static long Clock() {
    long ticks = Stopwatch.GetTimestamp(), second = Stopwatch.Frequency;
    return ticks / second * 1000000000 + ticks % second * 1000000000 / second;
  }

  static double[] Finite(double[] x, string name) {
    if (x == null) throw new ArgumentNullException(name);
    foreach (double value in x) {
      if (double.IsNaN(value) || double.IsInfinity(value)) {
        throw new ArgumentException("must be finite", name);
      }
    }
    return x;
  }

  /// Writes protocol buffers; a value of 0 and an empty list are absent.
  sealed class Message {
    readonly List<byte> bytes_ = new List<byte>();

    internal byte[] Bytes() => bytes_.ToArray();
    internal Message Number(int field, ulong value) {
      return value == 0 ? this : Varint((ulong)field << 3).Varint(value);
    }
    internal Message Real(int field, double value) {  // -0 is not 0
      return BitConverter.DoubleToInt64Bits(value) == 0 ? this : Present(field, value);
    }
    internal Message Present(int field, double value) => Varint((ulong)field << 3 | 1).Bits(value);
    internal Message Reals(int field, double[] values) {
      if (values == null || values.Length == 0) return this;
      Varint((ulong)field << 3 | 2).Varint((ulong)values.Length * 8);
      foreach (double value in values) Bits(value);
      return this;
    }
    internal Message Text(int field, string text) {
      return text == "" ? this : Block(field, Encoding.UTF8.GetBytes(text));
    }
    internal Message Sub(int field, Message message) => Block(field, message.Bytes());

    Message Block(int field, byte[] block) {
      Varint((ulong)field << 3 | 2).Varint((ulong)block.Length);
      bytes_.AddRange(block);
      return this;
    }
    Message Varint(ulong value) {
      for (; value > 127; value >>= 7) bytes_.Add((byte)(value & 127 | 128));
      bytes_.Add((byte)value);
      return this;
    }
    Message Bits(double value) {
      ulong bits = (ulong)BitConverter.DoubleToInt64Bits(value);
      for (int shift = 0; shift < 64; shift += 8) bytes_.Add((byte)(bits >> shift));
      return this;
    }
  }

  /// Reads protocol buffers. Whatever is not one is a FormatException.
  sealed class Reader {
    readonly byte[] bytes_;
    readonly int end_;
    int at_, wire_;
    internal int Field;

    internal Reader(byte[] bytes, int begin, int end) {
      bytes_ = bytes;
      at_ = begin;
      end_ = end;
    }
    internal bool Next() {
      if (at_ == end_) return false;
      ulong tag = Varint();
      Field = (int)(tag >> 3 & 0x1fffffff);
      wire_ = (int)(tag & 7);
      return true;
    }
    internal ulong Number() => Is(0) ? Varint() : 0;
    internal double Real() => Is(1) ? Bits() : 0;
    internal string Text() {
      int length = Length();
      at_ += length;
      return Encoding.UTF8.GetString(bytes_, at_ - length, length);
    }
    internal Reader Sub() {
      int length = Length();
      at_ += length;
      return new Reader(bytes_, at_ - length, at_);
    }
    /// Packed, or one value after those that came `before`.
    internal double[] Reals(double[] before) {
      int length = wire_ == 1 ? 8 : Length(), more = length / 8;
      if (length % 8 != 0) throw new FormatException("a list that ends within a number");
      var all = new double[before.Length + more];
      before.CopyTo(all, 0);
      for (int i = before.Length; i < all.Length; ++i) all[i] = Bits();
      return all;
    }
    internal uint[] Numbers(uint[] before) {
      var all = new List<uint>(before);
      if (wire_ == 0) {
        all.Add((uint)Varint());
      } else {
        for (Reader packed = Sub(); packed.at_ < packed.end_;) all.Add((uint)packed.Varint());
      }
      return all.ToArray();
    }
    internal void Skip() {
      if (wire_ == 0) Varint();
      else if (wire_ == 1) Advance(8);
      else if (wire_ == 5) Advance(4);
      else Advance(Length());
    }

    bool Is(int wire) => wire_ == wire ? true : throw new FormatException("another type of field");
    int Length() {
      Is(2);
      ulong length = Varint();
      if (length > (ulong)(end_ - at_)) throw new FormatException("a length beyond the end");
      return (int)length;
    }
    void Advance(int count) {
      if (count > end_ - at_) throw new FormatException("ends within a field");
      at_ += count;
    }
    ulong Varint() {
      ulong value = 0;
      for (int shift = 0; shift < 70; shift += 7) {
        Advance(1);
        byte next = bytes_[at_ - 1];
        value |= (ulong)(next & 127) << shift;
        if (next < 128) return value;
      }
      throw new FormatException("a number of more than 64 bits");
    }
    double Bits() {
      Advance(8);
      ulong bits = 0;
      for (int i = 1; i <= 8; ++i) bits = bits << 8 | bytes_[at_ - i];
      return BitConverter.Int64BitsToDouble((long)bits);
    }
  }
}

}  // namespace Haptic
