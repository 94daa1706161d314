// A wall on the first coordinate: it may not pass 0.314 rad. The wall is a plane, so the server
// keeps the probe behind it at 1 kHz. In Unity the loop's body is FixedUpdate().
//
//   mono VirtualWall.exe SERVER TOKEN SECONDS
using System;
using System.Threading;
using Haptic;

static class VirtualWall {
  static int Main(string[] arguments) {
    var options = new SessionOptions {
        Server = new Uri(arguments[0]), Token = arguments[1], ClientName = "virtual wall",
        NominalRateHz = 100};
    using (var session = new HapticSession(options)) {
      session.EngageWhenReady();
      int left = 100 * int.Parse(arguments[2]);
      for (; left > 0 && !session.Ended.IsCompleted; --left) {
        Thread.Sleep(10);
        DeviceState state = session.State;
        if (state == null) continue;
        var wall = new HapticPlane {Normal = new double[state.XProbe.Length], Offset = 0.314};
        wall.Normal[0] = 1;
        session.PublishContacts(new[] {wall}, state.XProbe);
      }
      if (session.Failure != null) Console.Error.WriteLine(session.Failure.Message);
      if (session.State == null) return 1;
      Console.WriteLine(session.State.State + " " + session.State.TauA[0]);
      int status = session.Failure == null ? 0 : 1;
      session.Dispose();
      session.Ended.Wait();  // the end of the program would cut the farewell off
      return status;
    }
  }
}
