// The names of UnityEngine that the example of client/README.md uses, so that the compiler reads
// it, and those that a class of ours could be confused with. Nothing runs.
namespace UnityEngine {

public class MonoBehaviour { }
public static class Debug { public static void Log(object message) { } }
public struct Plane { }
public struct ContactPoint { }
public class Event { }
public class Collision { }

}  // namespace UnityEngine
