// Contacts for a simulation that knows its own geometry: where a point of the tool is, how near an
// object is to it, and how that object gives way. Copy this file and ContactSolver.cs next to
// HapticSession.cs.
//
//   PointMap pad = Contacts.PointOnFinger(new[] {0.045, 0.040}, x, 1, 0.03, 0.008);
//   var contact = new Contact {Point = pad, Normal = n, Gap = gap, Stiffness = 400, Id = 1};
//   contact.Curvature = Contacts.SphereCurvature(n, radius + gap);
//   session.PublishContacts(new[] {Contacts.ContactAt(x, contact, coupling)}, x);
//
// Frame: any one that the point, the normal and the curvature share and that does not move with the
// coordinates. Vectors have three values; of a symmetric matrix the lower triangle is told, row by
// row. Wrong numbers are an ArgumentException that names them.
using System;
using System.Collections.Generic;
using System.Linq;

namespace Haptic {

/// A point of the tool, and how it moves with n <= 8 consecutive coordinates.
public sealed class PointMap {
  public int FirstCoordinate;
  public double[] Position;    // p, m
  public double[][] Jacobian;  // n: dp/dx_j, m per unit of x_j
  public double[][] Second = new double[0][];  // d2p/dx_j dx_k; empty: 0
}

/// A joint as it stands now.
public sealed class JointAxis {
  public double[] Origin;  // a point of the axis, m; without a meaning if prismatic
  public double[] Axis;    // of length 1; right-handed
  public bool Prismatic;
}

/// A point of the tool against an object. HapticPlane.cs has Id, Velocity, Mass and what else a
/// plane tells as well. An empty ObjectDirection is the normal, of a body that does not turn.
public sealed partial class Contact {
  public PointMap Point;
  public double[] Normal;  // of the object at the nearest point, outwards, of length 1
  public double Gap;       // from the object to the point along the normal, m; < 0: inside
  public double[] Curvature = new double[6];  // second derivative of the gap by the point, 1/m
  public double Stiffness = double.PositiveInfinity;  // of point and object in series, N/m
}

/// Result of Contacts.Solve().
public sealed class Solution {
  public double[] X;             // the proxy
  public HapticPlane[] Planes;   // ContactAt() of all contacts at X, for PublishContacts()
  public bool Converged;         // false: X is the best that was found
  public int Iterations;
}

public static class Contacts {
  const double FastestPoint = 0.5, UnknownRoundTrip = 0.2;  // m/s, s

  /// Coordinates: the joints of a serial chain, rad or m, from the base on; `point` is on the last
  /// one's link.
  public static PointMap PointOnJoints(IReadOnlyList<JointAxis> joints, double[] point,
                                       int firstCoordinate = 0) {
    double[][] jacobian = joints.Select(
        j => j.Prismatic ? j.Axis : Cross(j.Axis, Plus(point, -1, j.Origin))).ToArray();
    return new PointMap {
        FirstCoordinate = firstCoordinate, Position = point, Jacobian = jacobian,
        Second = Triangle(joints.Count, (k, j) => joints[j].Prismatic
                              ? new double[3] : Cross(joints[j].Axis, jacobian[k]))};
  }

  /// Coordinates: the flexions of a planar finger (MCP, PIP), rad. Frame: origin on the first axis,
  /// +x distal, +y dorsal; at 0 all phalanges lie along +x, and flexion turns them to -y. The point
  /// is `along` phalanx number `phalanx` (0, 1, ...) from its joint, and `palmar` of its line, m.
  public static PointMap PointOnFinger(double[] lengths, double[] x, int phalanx, double along,
                                       double palmar = 0, int firstCoordinate = 0) {
    var joints = new List<JointAxis>();
    var at = new double[3];
    double angle = 0;
    for (int k = 0; k <= phalanx; ++k) {
      if (k > 0) at = Along(at, lengths[k - 1], 0, angle);
      angle += x[firstCoordinate + k];
      joints.Add(new JointAxis {Origin = at, Axis = new double[] {0, 0, -1}});
    }
    return PointOnJoints(joints, Along(at, along, palmar, angle), firstCoordinate);
  }

  /// Coordinates: x, y, z of the point itself, m.
  public static PointMap PointItself(double[] x, int firstCoordinate = 0) => new PointMap {
      FirstCoordinate = firstCoordinate, Position = x.Skip(firstCoordinate).Take(3).ToArray(),
      Jacobian = new[] {Unit(0), Unit(1), Unit(2)}};

  /// Coordinates: x, y, z, m, and a quaternion qx, qy, qz, qw (a palm, a stylus), which is
  /// normalised. `offset`: the point in that frame, m.
  public static PointMap PointOnPose(double[] x, double[] offset, int firstCoordinate = 0) {
    PointMap map = PointItself(x, firstCoordinate);
    double[] raw = x.Skip(firstCoordinate + 3).Take(4).ToArray(), r = offset;
    double length = Math.Sqrt(Dot(raw, raw));
    double[] q = raw.Select(part => part / length).ToArray(), v = q.Take(3).ToArray();
    // R r is a quadratic form of q with the second derivative 2 M.
    Func<int, int, double[]> twice = (i, j) =>
        i == 3 && j == 3 ? Times(2, r)
        : i == 3 || j == 3 ? Times(2, Cross(Unit(Math.Min(i, j)), r))
        : Plus(Plus(Times(2 * r[j], Unit(i)), 2 * r[i], Unit(j)), i == j ? -2 : 0, r);
    double[] turned = Plus(Plus(Times(q[3] * q[3] - Dot(v, v), r), 2 * Dot(v, r), v), 2 * q[3],
                           Cross(v, r));
    // The derivatives of q^T M q / q^T q.
    double[][] slope = Enumerable.Range(0, 4).Select(
        i => Enumerable.Range(0, 4).Aggregate(new double[3],
                                              (sum, j) => Plus(sum, q[j], twice(i, j)))).ToArray();
    Func<int, int, double[]> bend = (i, j) => Times(1 / (length * length), Plus(Plus(Plus(
        twice(i, j), -2 * q[j], slope[i]), -2 * q[i], slope[j]),
        8 * q[i] * q[j] - (i == j ? 2 : 0), turned));
    map.Position = Plus(map.Position, 1, turned);
    map.Jacobian = map.Jacobian.Concat(
        slope.Select((s, i) => Times(1 / length, Plus(s, -2 * q[i], turned)))).ToArray();
    map.Second = Triangle(7, (i, j) => j >= 3 ? bend(i - 3, j - 3) : new double[3]);
    return map;
  }

  /// Curvature of a ball; `distance` of the point from its centre, m, not 0; < 0: the point is
  /// inside a hollow one, and the normal points inwards.
  public static double[] SphereCurvature(double[] normal, double distance) =>
      Across(distance, normal);
  /// Curvature of a cylinder with this axis (of length 1); `distance` from the axis.
  public static double[] CylinderCurvature(double[] normal, double[] axis, double distance) =>
      Across(distance, normal, axis);

  /// The contact as the server takes it, linearised at the sample's position `x`. `coupling`: c of
  /// the simulation's own coupling, whose energy is c/2 |x - XProbe|^2: N/m if x is in m, N m/rad
  /// if in rad.
  public static HapticPlane ContactAt(double[] x, Contact contact, double coupling) {
    PointMap point = contact.Point;
    double[] n = contact.Normal, K = contact.Curvature;
    int first = point.FirstCoordinate, count = point.Jacobian.Length;
    Check(first >= 0 && first + count <= x.Length, "Point.FirstCoordinate " + first + ", " + count +
          " coordinates: must lie within the " + x.Length + " of x");
    int triangle = count * (count + 1) / 2;
    Check(point.Second.Length == 0 || point.Second.Length == triangle, "Point.Second: has " +
          point.Second.Length + " vectors, must have 0 or " + triangle);
    double[] gradient = point.Jacobian.Select(column => Dot(n, column)).ToArray();
    double[] curvature = Triangle(count, (j, k) => {
      double[] a = point.Jacobian[j];
      double[] bent = {K[0] * a[0] + K[1] * a[1] + K[3] * a[2],
                       K[1] * a[0] + K[2] * a[1] + K[4] * a[2],
                       K[3] * a[0] + K[4] * a[1] + K[5] * a[2]};
      return Dot(point.Jacobian[k], bent);
    });
    if (point.Second.Length > 0) {
      curvature = curvature.Zip(point.Second, (own, second) => own + Dot(n, second)).ToArray();
    }
    var plane = new HapticPlane {
        Normal = new double[x.Length],
        Offset = contact.Gap - gradient.Select((slope, i) => slope * x[first + i]).Sum(),
        Compliance = coupling / contact.Stiffness,
        Curvature = curvature.Any(value => value != 0) ? curvature : new double[0],
        FirstCoordinate = (uint)first};
    Contact.Tell(contact, coupling, plane);
    if (plane.Object != 0 && plane.ObjectDirection.Length == 0) plane.ObjectDirection = n;
    for (int i = 0; i < count; ++i) plane.Normal[first + i] = -gradient[i];
    return plane;
  }

  /// Contacts with a gap up to this, m, should be told before they are touched: how far a point may
  /// get until the next sample's law is in use. roundTrip: s; 0: not known yet. period: s, of your
  /// samples. vMax: m/s, of the point.
  public static double ContactHorizon(double roundTrip, double period,
                                      double vMax = FastestPoint) =>
      vMax * ((roundTrip > 0 ? roundTrip : UnknownRoundTrip) + period);

  /// The x that minimises, near `start`,
  ///   coupling / 2 (x - xProbe)^T W (x - xProbe) + sum_i Stiffness_i / 2 min(Gap_i(x), 0)^2,
  /// with Gap_i >= 0 where the stiffness is infinite. `contacts` gives those of the tool at x,
  /// touched or near; from one x to the next one may come or go where its gap is > 0. `start`: the
  /// last proxy, so that the tool stays on the side of each object that it came from; null: the
  /// probe. `weights`: the diagonal of W; null: all 1. x - xProbe is a plain difference of numbers.
  /// The method and more is in C++'s solve.hpp.
  public static Solution Solve(Func<double[], IReadOnlyList<Contact>> contacts, double[] xProbe,
                               double coupling, double[] start = null, double[] weights = null,
                               int iterations = 50, double tolerance = 1e-10) =>
      new Solver(contacts, xProbe, coupling, weights).From(start ?? xProbe, iterations, tolerance);

  internal static void Check(bool right, string words) {
    if (!right) throw new ArgumentException(words);
  }
  internal static double Dot(double[] a, double[] b) {
    double sum = 0;
    for (int i = 0; i < a.Length; ++i) sum += a[i] * b[i];
    return sum;
  }
  internal static double[] Plus(double[] a, double factor, double[] b) =>
      a.Select((value, i) => value + factor * b[i]).ToArray();
  static double[] Times(double factor, double[] a) => a.Select(value => factor * value).ToArray();
  static double[] Unit(int k) => Enumerable.Range(0, 3).Select(i => i == k ? 1.0 : 0).ToArray();
  static double[] Cross(double[] a, double[] b) => new[] {
      a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  /// The point `along` and `palmar` of a phalanx that begins at `from`.
  static double[] Along(double[] from, double along, double palmar, double angle) {
    double c = Math.Cos(angle), s = Math.Sin(angle);
    return new[] {from[0] + along * c - palmar * s, from[1] - along * s - palmar * c, 0};
  }
  /// f(row, column) of a lower triangle.
  static T[] Triangle<T>(int n, Func<int, int, T> f) =>
      Enumerable.Range(0, n).SelectMany(
          row => Enumerable.Range(0, row + 1).Select(column => f(row, column))).ToArray();
  static double[] Across(double distance, params double[][] directions) =>
      Triangle(3, (i, j) => ((i == j ? 1 : 0) - directions.Sum(a => a[i] * a[j])) / distance);
}

}  // namespace Haptic
