// How Contacts.Solve() finds the proxy: C++'s solve.cpp in C#.
using System;
using System.Collections.Generic;
using System.Linq;

namespace Haptic {

/// Sequential quadratic programming.
sealed class Solver {
  const int Halvings = 30;
  // Least compliance of a contact, relative to what the coupling gives way.
  const double Rigid = 1e-12;
  const double Noise = 1e-14;  // of the energy: what rounding may raise it by

  /// The contacts at one x.
  sealed class Place {
    internal double[] X, Gaps;
    internal double[][] Gradients;
    internal HapticPlane[] Planes;
  }

  readonly Func<double[], IReadOnlyList<Contact>> contacts_;
  readonly double[] probe_, weights_;
  readonly double coupling_;

  internal Solver(Func<double[], IReadOnlyList<Contact>> contacts, double[] probe, double coupling,
                  double[] weights) {
    contacts_ = contacts;
    probe_ = probe;
    coupling_ = coupling;
    weights_ = weights ?? probe.Select(_ => 1.0).ToArray();
    Check("xProbe", probe, probe.Length);
    Check("weights", weights_, probe.Length, true);
    Check("coupling", new[] {coupling}, 1, true);
  }

  internal Solution From(double[] start, int iterations, double tolerance) {
    Check("start", start, probe_.Length);
    Place here = At(start);
    var found = new Solution();
    bool still = false, stuck = false;
    while (!still && !stuck && found.Iterations < iterations) {
      ++found.Iterations;
      double[] way, pushes;
      Step(here, out way, out pushes);
      double rigid = 1.5 * pushes.DefaultIfEmpty(0).Max();  // > the pushes: no violation pays
      double energy = Energy(here, rigid), share = 1;
      for (int halving = 0;; ++halving, share /= 2) {
        Place there = At(Contacts.Plus(here.X, share, way));
        bool falls = Energy(there, rigid) <= energy + Noise * Math.Abs(energy);
        stuck = !falls && halving == Halvings;
        if (falls) here = there;
        if (falls || stuck) break;
      }
      still = share * way.Select(Math.Abs).DefaultIfEmpty(0).Max() <= tolerance;
    }
    bool inside = here.Planes.Where((plane, i) => plane.Compliance == 0 && here.Gaps[i] <
        -10 * tolerance * Math.Sqrt(Contacts.Dot(plane.Normal, plane.Normal))).Any();
    found.X = here.X;
    found.Planes = here.Planes;
    found.Converged = still && !stuck && !inside;
    return found;
  }

  Place At(double[] x) {
    IReadOnlyList<Contact> told = contacts_(x);
    HapticPlane[] planes = told.Select((contact, i) => {
      string name = "contacts[" + i + "]";
      Check(name + ".Gap", new[] {contact.Gap}, 1);
      Contacts.Check(contact.Stiffness > 0, name + ".Stiffness: " + contact.Stiffness +
                     ", must be > 0");
      HapticPlane plane = Contacts.ContactAt(x, contact, coupling_);
      Check(name + ".Normal . Point.Jacobian", plane.Normal, x.Length);
      Check(name + ".Curvature", plane.Curvature, plane.Curvature.Length);
      return plane;
    }).ToArray();
    return new Place {X = x, Planes = planes, Gaps = told.Select(contact => contact.Gap).ToArray(),
                      Gradients = planes.Select(
                          plane => plane.Normal.Select(value => -value).ToArray()).ToArray()};
  }

  /// Energy over the coupling; a rigid contact costs `rigid` times its depth.
  double Energy(Place at, double rigid) =>
      at.X.Select((v, i) => weights_[i] * (v - probe_[i]) * (v - probe_[i]) / 2).Sum() +
      at.Planes.Select((plane, i) => {
        double depth = Math.Max(-at.Gaps[i], 0);
        return plane.Compliance > 0 ? depth * depth / plane.Compliance / 2 : rigid * depth;
      }).Sum();

  /// To the minimum of a model of the energy: first with flat gaps, then with the curvature that
  /// their pushes give the energy, unless that model has no minimum.
  void Step(Place at, out double[] way, out double[] pushes) {
    int n = probe_.Length;
    double[][] H = weights_.Select((weight, i) => new double[n]).ToArray();
    for (int i = 0; i < n; ++i) H[i][i] = weights_[i];
    StepBy(at, Factor(H), out way, out pushes);
    for (int p = 0; p < at.Planes.Length; ++p) {
      double[] curvature = at.Planes[p].Curvature;
      int first = (int)at.Planes[p].FirstCoordinate;
      for (int k = 0, i = first; k < curvature.Length; ++i) {
        for (int j = first; j <= i; ++j) H[i][j] -= pushes[p] * curvature[k++];
      }
    }
    double[][] L = Factor(H);
    if (L != null) StepBy(at, L, out way, out pushes);
  }

  void StepBy(Place at, double[][] L, out double[] way, out double[] pushes) {
    double[] free = Solved(L, at.X.Select((v, i) => weights_[i] * (probe_[i] - v)).ToArray());
    double[][] moves = at.Gradients.Select(gradient => Solved(L, gradient)).ToArray();
    double[][] A = at.Gradients.Select(
        g => moves.Select(move => Contacts.Dot(g, move)).ToArray()).ToArray();
    for (int i = 0; i < A.Length; ++i) {
      double yields = Math.Max(at.Planes[i].Compliance, Rigid * A[i][i]);
      A[i][i] = A[i][i] + yields > 0 ? A[i][i] + yields : 1;
    }
    pushes = Pushes(A, at.Gaps.Select((g, i) => g + Contacts.Dot(at.Gradients[i], free)).ToArray());
    way = free;
    for (int i = 0; i < moves.Length; ++i) way = Contacts.Plus(way, pushes[i], moves[i]);
  }

  /// The m >= 0 that minimises m^T A m / 2 + b^T m, A positive definite (Lawson and Hanson).
  static double[] Pushes(double[][] A, double[] b) {
    var m = new double[b.Length];
    var pushing = new List<int>();
    double least = 1e-14 * b.Select(Math.Abs).DefaultIfEmpty(0).Max();
    for (int turn = 0; turn < 3 * b.Length; ++turn) {
      int deepest = -1;
      double depth = least;
      for (int i = 0; i < b.Length; ++i) {
        double inside = -b[i] - Contacts.Dot(A[i], m);
        if (inside <= depth || pushing.Contains(i)) continue;
        deepest = i;
        depth = inside;
      }
      if (deepest < 0) break;
      pushing.Add(deepest);
      for (int lettingGo = 0; lettingGo >= 0;) {
        double[][] L = Factor(
            pushing.Select(i => pushing.Select(j => A[i][j]).ToArray()).ToArray());
        if (L == null) return m;
        double[] wanted = Solved(L, pushing.Select(i => -b[i]).ToArray());
        double share = 1;  // of the way to what is wanted, until one of them lets go
        lettingGo = -1;
        for (int k = 0; k < wanted.Length; ++k) {
          double now = m[pushing[k]];
          if (wanted[k] > 0 || now > share * (now - wanted[k])) continue;
          share = now / (now - wanted[k]);
          lettingGo = pushing[k];
        }
        for (int k = 0; k < wanted.Length; ++k) {
          m[pushing[k]] += share * (wanted[k] - m[pushing[k]]);
        }
        if (lettingGo >= 0) m[lettingGo] = 0;
        pushing.Remove(lettingGo);
      }
    }
    return m;
  }

  /// Cholesky's factor of a symmetric A; null: A is not positive definite.
  static double[][] Factor(double[][] A) {
    double[][] L = A.Select(row => new double[row.Length]).ToArray();
    for (int i = 0; i < A.Length; ++i) {
      for (int j = 0; j <= i; ++j) {
        double rest = A[i][j];
        for (int k = 0; k < j; ++k) rest -= L[i][k] * L[j][k];
        if (i == j && !(rest > 1e-14 * A[i][i])) return null;
        L[i][j] = i == j ? Math.Sqrt(rest) : rest / L[j][j];
      }
    }
    return L;
  }

  /// A^-1 b, by the factor L of A.
  static double[] Solved(double[][] L, double[] b) {
    var x = (double[])b.Clone();
    for (int i = 0; i < x.Length; ++i) {
      for (int k = 0; k < i; ++k) x[i] -= L[i][k] * x[k];
      x[i] /= L[i][i];
    }
    for (int i = x.Length - 1; i >= 0; --i) {
      for (int k = i + 1; k < x.Length; ++k) x[i] -= L[k][i] * x[k];
      x[i] /= L[i][i];
    }
    return x;
  }

  static void Check(string name, double[] values, int size, bool positive = false) {
    Contacts.Check(values.Length == size,
                   name + ": has " + values.Length + " values, must have " + size);
    for (int i = 0; i < size; ++i) {
      bool right = !double.IsNaN(values[i]) && !double.IsInfinity(values[i]) &&
          !(positive && values[i] <= 0);
      Contacts.Check(right, name + "[" + i + "]: " + values[i] + ", must be finite" +
                     (positive ? " and > 0" : ""));
    }
  }
}

}  // namespace Haptic
