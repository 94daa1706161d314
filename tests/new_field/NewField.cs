// Prints the fields that only a test declares: of a state's bytes, and the last bytes of a contact
// of 3 N with a coupling of 2 N/m.
using System;
using System.IO;
using System.Reflection;

namespace Haptic {

static class NewField {
  const BindingFlags Hidden = BindingFlags.NonPublic | BindingFlags.Static | BindingFlags.Instance;

  static object Of(Type[] types, params object[] arguments) {
    return typeof(HapticSession).GetMethod("Of", Hidden, null, types, null).Invoke(null, arguments);
  }
  static void Main(string[] arguments) {
    byte[] bytes = File.ReadAllBytes(arguments[0]);
    Type reader = typeof(HapticSession).GetNestedType("Reader", Hidden);
    object from = Activator.CreateInstance(reader, Hidden, null,
        new object[] {bytes, 0, bytes.Length}, null);
    var state = (DeviceState)Of(new[] {reader, typeof(DeviceState)}, from, new DeviceState());
    Console.WriteLine(state.Tested + " " + state.TestedList[0]);

    var contact = new Contact {Point = Contacts.PointItself(new double[3]),
                               Normal = new double[] {1, 0, 0}, Stickiness = 3};
    object message = Of(new[] {typeof(HapticPlane)}, Contacts.ContactAt(new double[3], contact, 2));
    bytes = (byte[])message.GetType().GetMethod("Bytes", Hidden).Invoke(message, null);
    Console.WriteLine(BitConverter.ToString(bytes, bytes.Length - 10));
  }
}

}  // namespace Haptic
