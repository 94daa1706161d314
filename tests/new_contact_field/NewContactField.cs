// A contact with the field that only a test declares (new_field.py): contact_at() divides it by the
// coupling, 2 N/m, and it goes out by its number, 1000. Prints what went wrong.
using System;
using System.Linq;
using System.Reflection;
using Haptic;

static class NewContactField {
  static int Main() {
    var contact = new Contact {Point = Contacts.PointItself(new double[3]),
                               Normal = new double[] {1, 0, 0}, Stickiness = 3};
    HapticPlane plane = Contacts.ContactAt(new double[3], contact, 2);
    object message = typeof(HapticSession).GetMethods(BindingFlags.NonPublic | BindingFlags.Static)
        .Single(method => method.Name == "Of" &&
                method.GetParameters()[0].ParameterType == typeof(HapticPlane))
        .Invoke(null, new object[] {plane});
    byte[] bytes = (byte[])message.GetType().GetMethod("Bytes", BindingFlags.NonPublic |
                                                       BindingFlags.Instance).Invoke(message, null);
    byte[] expected = {0xc1, 0x3e, 0, 0, 0, 0, 0, 0, 0xf8, 0x3f};  // 1000 << 3 | 1, then 1.5
    if (bytes.Skip(bytes.Length - expected.Length).SequenceEqual(expected)) return 0;
    Console.Error.WriteLine(BitConverter.ToString(bytes));
    return 1;
  }
}
