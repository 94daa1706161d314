// HapticSession.cs in lock-step: does what stdin says, a line each, and answers with a line, as
// tests/client/c/lock_step_client.c.
//
//   LockStepClient.exe SERVER TOKEN
using System;
using System.Globalization;
using System.Linq;
using Haptic;

static class LockStepClient {
  static string Bits(double value) => BitConverter.DoubleToInt64Bits(value).ToString("x16");
  static double Number(string bits) =>
      BitConverter.Int64BitsToDouble(long.Parse(bits, NumberStyles.HexNumber));

  static void Main(string[] arguments) {
    var session = new HapticSession(new SessionOptions {
        Server = new Uri(arguments[0]), Token = arguments[1], NominalRateHz = 100,
        Timeout = TimeSpan.FromSeconds(60)});
    string answer = session.Opened.Wait(60000) ? "0 0 0" : "-1 0 0";
    for (string line; ; ) {
      Console.WriteLine(answer);
      Console.Out.Flush();
      if ((line = Console.ReadLine()) == null) return;
      string[] words = line.Split(' ');
      if (words[0] == "free") session.PublishFree();
      if (words[0] == "held") session.PublishHeld(words.Skip(1).Select(Number).ToArray());
      if (words[0] == "engage") session.Engage().Wait();
      if (words[0] != "state") continue;
      DeviceState state = session.State;
      answer = "0 " + state.Seq + " " + Bits(state.TauA[0]);
    }
  }
}
