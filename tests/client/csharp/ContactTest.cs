// Contacts.cs against the shared vectors of all languages (make_contacts.py), and what is refused.
// The vectors come by standard input, a line "PATH VALUE..." each: "solve.3.contacts.0.tool.first
// 2". Prints what went wrong; exit status 0 if nothing did.
using System;
using System.Collections.Generic;
using System.Globalization;
using System.Linq;
using Haptic;

static class ContactTest {
  static readonly Dictionary<string, string> All = new Dictionary<string, string>();

  static void Check(bool right, string what) {
    if (!right) throw new Exception("not so: " + what);
  }
  static double Parsed(string text) => double.Parse(text, CultureInfo.InvariantCulture);
  static double[] Numbers(string path) =>
      All[path].Split(new[] {' '}, StringSplitOptions.RemoveEmptyEntries).Select(Parsed).ToArray();
  static double Number(string path) => Parsed(All[path]);
  /// path.0, path.1, ... as long as there are any.
  static IEnumerable<string> Rows(string path) {
    for (int i = 0; All.Keys.Any(key => key.StartsWith(path + "." + i + ".")); ++i) {
      yield return path + "." + i;
    }
  }
  static void Near(double[] actual, double[] expected, double within, string what) {
    Check(actual.Length == expected.Length, what + " has " + actual.Length + " values");
    for (int i = 0; i < actual.Length; ++i) {
      Check(Math.Abs(actual[i] - expected[i]) <= within,
            what + "[" + i + "]: " + actual[i] + ", not " + expected[i]);
    }
  }

  static PointMap PointOf(string tool, double[] x) {
    int first = (int)Number(tool + ".first");
    switch (All[tool + ".kind"]) {
      case "itself": return Contacts.PointItself(x, first);
      case "pose": return Contacts.PointOnPose(x, Numbers(tool + ".offset"), first);
      case "finger": return Contacts.PointOnFinger(
          Numbers(tool + ".lengths"), x, (int)Number(tool + ".phalanx"), Number(tool + ".along"),
          Number(tool + ".palmar"), first);
      default: return Contacts.PointOnJoints(Rows(tool + ".joints").Select(joint => new JointAxis {
          Origin = Numbers(joint + ".origin"), Axis = Numbers(joint + ".axis"),
          Prismatic = Number(joint + ".prismatic") != 0}).ToArray(), Numbers(tool + ".point"),
          first);
    }
  }

  static Contact ContactOf(string told, double[] x) {
    string thing = told + ".object", shape = All[thing + ".shape"];
    PointMap point = PointOf(told + ".tool", x);
    double[] axis = Numbers(thing + ".axis"), centre = Numbers(thing + ".centre");
    double[] away = point.Position.Select((p, k) => p - centre[k]).ToArray();
    double along = away.Select((a, k) => a * axis[k]).Sum(), radius = Number(thing + ".radius");
    if (shape == "rod") away = away.Select((a, k) => a - along * axis[k]).ToArray();
    double distance = Math.Sqrt(away.Sum(a => a * a)) * (radius > 0 ? 1 : -1);
    double[] n = shape == "wall" ? axis : away.Select(a => a / distance).ToArray();
    var contact = new Contact {
        Point = point, Normal = n, Gap = shape == "wall" ? along : distance - radius,
        Velocity = Number(told + ".velocity"), Id = (uint)Number(told + ".id"),
        Mass = Number(told + ".mass"), Damping = Number(told + ".damping"),
        GroundStiffness = Number(told + ".ground_stiffness"), Load = Number(told + ".load"),
        Object = (uint)Number(told + ".on"), ObjectDirection = Numbers(told + ".direction")};
    if (shape == "ball") contact.Curvature = Contacts.SphereCurvature(n, distance);
    if (shape == "rod") contact.Curvature = Contacts.CylinderCurvature(n, axis, distance);
    if (All[told + ".stiffness"] != "rigid") contact.Stiffness = Number(told + ".stiffness");
    if (All[told + ".uncertainty"] != "") contact.Uncertainty = Number(told + ".uncertainty");
    return contact;
  }

  static void Planes() {
    foreach (string row in Rows("planes")) {
      double[] x = Numbers(row + ".x");
      string to = row + ".plane.";
      HapticPlane plane = Contacts.ContactAt(x, ContactOf(row + ".contact", x),
                                             Number(row + ".coupling"));
      Near(plane.Normal, Numbers(to + "normal"), 1e-15, row + " normal");
      Near(plane.Curvature, Numbers(to + "curvature"), 1e-13, row + " curvature");
      Near(plane.ObjectDirection, Numbers(to + "object_direction"), 1e-15, row + " direction");
      Near(new[] {plane.Offset, plane.Compliance, plane.Velocity, plane.Mass, plane.Damping,
                  plane.GroundStiffness, plane.Load, plane.FirstCoordinate, plane.Id, plane.Object},
           new[] {"offset", "compliance", "velocity", "mass", "damping", "ground_stiffness", "load",
                  "first_coordinate", "id", "object"}.Select(name => Number(to + name)).ToArray(),
           1e-15, row);
      Check(plane.Uncertainty.HasValue == (All[to + "uncertainty"] != ""), row + " uncertainty");
      if (plane.Uncertainty.HasValue) {
        Check(plane.Uncertainty == Number(to + "uncertainty"), row + " uncertainty");
      }
    }
  }

  static void Proxies() {
    foreach (string row in Rows("solve")) {
      Solution found = Contacts.Solve(
          x => Rows(row + ".contacts").Select(told => ContactOf(told, x)).ToArray(),
          Numbers(row + ".x_probe"), Number(row + ".coupling"), Numbers(row + ".start"),
          Numbers(row + ".weights"));
      Check(found.Converged && found.Iterations <= 12, All[row + ".name"] + " converged");
      Check(found.Planes.Length == Rows(row + ".contacts").Count(), row + " planes");
      Near(found.X, Numbers(row + ".x"), 1e-10, All[row + ".name"]);
    }
  }

  static Contact Wall(double gap, double slope, double stiffness = double.PositiveInfinity) =>
      new Contact {Point = new PointMap {Position = new double[3],
                                         Jacobian = new[] {new[] {slope, 0, 0}}},
                   Normal = new double[] {1, 0, 0}, Gap = gap, Stiffness = stiffness};

  static void Refused(string words, Action action) {
    try {
      action();
    } catch (ArgumentException error) {
      Check(error.Message == words, error.Message);
      return;
    }
    throw new Exception("not refused: " + words);
  }

  static void Limits() {
    Solution found = Contacts.Solve(x => new[] {Wall(-x[0], -1), Wall(x[0] - 1, 1)},
                                    new double[] {5}, 1);
    Check(!found.Converged, "a contradiction converges");
    Near(found.X, new[] {0.5}, 1e-6, "the least violation");
    found = Contacts.Solve(x => new[] {ContactOf("solve.0.contacts.0", x)},
                           new[] {0.003, 0.001, 0}, 1, new[] {0, 0.03, 0}, null, 2);
    Check(!found.Converged && found.Iterations == 2, "it stops after its iterations");
    double[] zero = {0};
    Refused("xProbe[0]: NaN, must be finite",
            () => Contacts.Solve(x => new Contact[0], new[] {double.NaN}, 1));
    Refused("coupling[0]: 0, must be finite and > 0",
            () => Contacts.Solve(x => new Contact[0], zero, 0));
    Refused("start: has 2 values, must have 1",
            () => Contacts.Solve(x => new Contact[0], zero, 1, new double[2]));
    Refused("contacts[0].Gap[0]: NaN, must be finite",
            () => Contacts.Solve(x => new[] {Wall(double.NaN, 1)}, zero, 1));
    Refused("contacts[0].Stiffness: -1, must be > 0",
            () => Contacts.Solve(x => new[] {Wall(0, 1, -1)}, zero, 1));
    Refused("Point.FirstCoordinate 1, 3 coordinates: must lie within the 3 of x",
            () => Contacts.ContactAt(new double[3], new Contact {
                Point = Contacts.PointItself(new double[4], 1), Normal = new double[3]}, 1));
  }

  static int Main() {
    for (string line = Console.ReadLine(); line != null; line = Console.ReadLine()) {
      string[] parts = line.Split(new[] {' '}, 2);
      All[parts[0]] = parts.Length > 1 ? parts[1] : "";
    }
    try {
      Planes();
      Proxies();
      Limits();
      foreach (string row in Rows("horizon")) {
        double horizon = Contacts.ContactHorizon(
            Number(row + ".round_trip_s"), Number(row + ".period_s"), Number(row + ".v_max"));
        Near(new[] {horizon}, new[] {Number(row + ".metres")}, 1e-15, row);
      }
      return 0;
    } catch (Exception error) {
      Console.Error.WriteLine(error);
      return 1;
    }
  }
}
