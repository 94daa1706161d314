// Prints the fields that only a test declares, of a state's bytes.
using System;
using System.IO;
using System.Reflection;

namespace Haptic {

static class NewField {
  static void Main(string[] arguments) {
    byte[] bytes = File.ReadAllBytes(arguments[0]);
    const BindingFlags Hidden = BindingFlags.NonPublic | BindingFlags.Static |
        BindingFlags.Instance;
    Type reader = typeof(HapticSession).GetNestedType("Reader", Hidden);
    object from = Activator.CreateInstance(reader, Hidden, null,
        new object[] {bytes, 0, bytes.Length}, null);
    MethodInfo read = typeof(HapticSession).GetMethod("Of", Hidden, null,
        new[] {reader, typeof(DeviceState)}, null);
    var state = (DeviceState)read.Invoke(null, new[] {from, new DeviceState()});
    Console.WriteLine(state.Tested + " " + state.TestedList[0]);
  }
}

}  // namespace Haptic
