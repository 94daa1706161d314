// HapticSession.cs against a hapticd that serves finger_constant, or against a peer that says what
// it must not. Prints what went wrong; exit status 0 if nothing did.
//
//   SessionTest.exe all SERVER TOKEN
//   SessionTest.exe refused SERVER TOKEN SECONDS    SECONDS: to wait for an answer
//   SessionTest.exe deserted SERVER TOKEN SECONDS   opens; nothing that follows is of use
//   SessionTest.exe released SERVER TOKEN           gives force up while it asks for it
using System;
using System.Diagnostics;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using Haptic;

static class SessionTest {
  static void Check(bool right, string what) {
    if (!right) throw new Exception("not so: " + what);
  }
  static void Eventually(Func<bool> condition, string what) {
    for (var time = Stopwatch.StartNew(); !condition(); Thread.Sleep(5)) {
      if (time.Elapsed > TimeSpan.FromSeconds(60)) throw new Exception("never: " + what);
    }
  }
  /// The exception with which the task ends, within a minute.
  static HapticException Refusal(Task task) {
    try {
      Check(task.Wait(60000), "it ends");
    } catch (AggregateException error) {
      return (HapticException)error.GetBaseException();
    }
    throw new Exception("it was not refused");
  }
  static HapticSession Open(string server, string token, string name, double seconds = 60,
                            string device = "") =>
      new HapticSession(new SessionOptions {
          Server = new Uri(server), Token = token, ClientName = name, Device = device,
          NominalRateHz = 100, Timeout = TimeSpan.FromSeconds(seconds)});

  static void Main(string[] arguments) {
    try {
      if (arguments[0] == "refused") {
        HapticSession session = Open(arguments[1], arguments[2], "refused",
                                     double.Parse(arguments[3]));
        Console.WriteLine(Refusal(session.Opened).Message);
        Check(session.Ended.Wait(60000) && !session.Connected, "the session ended");
        session.PublishFree();  // nothing happens
        session.Dispose();
      } else if (arguments[0] == "deserted") {
        HapticSession session = Open(arguments[1], arguments[2], "deserted",
                                     double.Parse(arguments[3]));
        Check(session.Opened.Wait(60000), "it is open");
        Console.WriteLine(Refusal(session.Engage()).Message);
        Check(session.Ended.Wait(60000), "the session ended");
        Console.WriteLine(session.Failure.Message);
        Console.WriteLine(session.State == null ? "" : string.Join(" ", session.State.XProbe));
      } else if (arguments[0] == "released") {
        HapticSession session = Open(arguments[1], arguments[2], "released");
        Check(session.Opened.Wait(60000), "it is open");
        session.EngageWhenReady();
        Thread.Sleep(200);  // it is on its way
        Console.WriteLine(Refusal(session.Release()).Message);
      } else {
        All(arguments[1], arguments[2]);
      }
    } catch (Exception error) {
      Console.Error.WriteLine(error);
      Environment.Exit(1);
    }
  }

  static void All(string server, string token) {
    HapticSession session = Open(server, token, "in C#");
    Check(session.Opened.Wait(60000) && session.Connected, "it is open");
    Eventually(() => session.State != null, "a state");
    Check(session.State.Q.Length == 2 && session.State.XProbe.Length == 2, "two joints");
    Eventually(() => session.State.State == Lifecycle.Armed, "the finger is armed");
    Refusals(session, server, token);
    Force(session);
    Stop(session);
    session.Dispose();
    session.Dispose();
    Check(session.Ended.Wait(60000) && session.Failure == null, "Dispose() is no failure");
    Check(!session.Connected, "it ended");
    HapticSession next = Open(server, token, "the next");  // the lease did not wait
    Check(next.Opened.Wait(60000), "the next controller");
    next.Dispose();
    Check(next.Ended.Wait(60000), "it ends too");
  }

  static void Refusals(HapticSession session, string server, string token) {
    HapticSession second = Open(server, token, "the second");
    HapticException held = Refusal(second.Opened);
    Check(held.Reason == "LEASE_HELD" && held.Message.Contains("in C#"), held.ToString());
    Check(second.Failure == held, "it is the failure too");
    HapticSession glove = Open(server, token, "of a glove", device: "glove");
    Check(Refusal(glove.Opened).Message.Contains("glove"), "no such device");
    HapticException early = Refusal(session.Engage());
    Check(early.Reason != "" && early.Message != "", early.ToString());
    Throws<ArgumentNullException>(() => session.PublishHeld(null));
    Throws<ArgumentException>(() => session.PublishHeld(new[] {0.0, double.NaN}));
    Throws<ArgumentException>(() => session.PublishContacts(new HapticPlane[33], new double[2]));
    Throws<ArgumentException>(() => session.PublishHeld(new double[9000]));
    session.PublishHeld(new double[3]);
    Eventually(() => session.LastRejection.Contains("position"), "the server's word on 3 values");
  }

  static void Throws<T>(Action action) where T : Exception {
    try {
      action();
    } catch (T) {
      return;
    }
    throw new Exception("no " + typeof(T).Name);
  }

  static void Force(HapticSession session) {
    Task engaged = session.EngageWhenReady();
    Eventually(() => {
      DeviceState state = session.State;
      double[] x = {state.XProbe[0] + 0.01, state.XProbe[1]};
      if (state.Gain > 0) session.PublishHeld(x); else session.PublishFree();
      return state.State == Lifecycle.Engaged && state.TauA[0] > 0.1;
    }, "force towards the held proxy");
    Check(engaged.Wait(60000), "EngageWhenReady() is done");
    Eventually(() => {
      DeviceState state = session.State;
      var wall = new HapticPlane {Normal = new double[] {1, 0}, Id = 7,
                              Offset = state.XProbe[0] - 0.005, Compliance = 0.1,
                              Curvature = new double[] {0, 0, 0}, Uncertainty = 0};
      session.PublishContacts(new[] {wall}, state.XProbe);
      return state.ActivePlanes == 1 && state.ErrorBound.Length == 1 && state.TauA[0] < 0;
    }, "a contact that pushes back");
    for (int i = 0; i < 1000; ++i) session.PublishFree();
    Check(session.Conflated > 0, "a burst is conflated");
    Check(session.Accepted > 0 && session.Published > 1000, "samples are counted");
    Check(session.Release().Wait(60000), "Release() is answered");
    Eventually(() => session.State.State == Lifecycle.Armed, "no force after Release()");
  }

  static void Stop(HapticSession session) {
    Eventually(() => session.State.Staleness == Staleness.Lost,
               "a sample that is too old for force");
    Task waiting = session.EngageWhenReady();  // no samples come, so it waits
    HapticEvent told;
    while (session.TryNextEvent(out told)) { }
    Check(session.EmergencyStop("a test in C#").Wait(60000), "EmergencyStop() is answered");
    Eventually(() => session.State.State == Lifecycle.Fault, "FAULT");
    Check(session.State.Faults == 1 << 7, "it is EMERGENCY_STOP");
    Eventually(() => session.TryNextEvent(out told) && told.Reason == "EMERGENCY_STOP",
               "its event");
    Refusal(waiting);
    Check(Refusal(session.EngageWhenReady()).Reason == "FAULT", "no force in FAULT");
  }
}
