// MuJoCo's JavaScript as a page may run it whose policy forbids eval: embind makes two kinds of
// functions of text, which here are closures that do the same.
//
//   node strict_mujoco.mjs node_modules/@mujoco/mujoco/mujoco.js OUTPUT
import fs from "node:fs";

const [input, output] = process.argv.slice(2);
const closures = [
  ["var invokerFn = new Function(...args, invokerFnBody)(...closureArgs);", `
      var firstWired = isClassMethodFunc ? 1 : 2;
      var invokerFn = function (...given) {
        checkArgCount(given.length, minArgs, expectedArgCount, humanName, throwBindingError);
        var destructors = needsDestructorStack ? [] : null;
        var wired = isClassMethodFunc ? [argTypes[1]['toWireType'](destructors, this)] : [];
        for (var i = 0; i < expectedArgCount; ++i) {
          wired.push(argTypes[i + 2]['toWireType'](destructors, given[i]));
        }
        var rv = cppInvokerFunc(cppTargetFunc, ...wired);
        if (needsDestructorStack) {
          runDestructors(destructors);
        } else {
          wired.forEach((value, i) => argTypes[firstWired + i].destructorFunction?.(value));
        }
        if (returns) return argTypes[0]['fromWireType'](rv);
      };`],
  ["var invokerFunction = new Function(...params, functionBody)(...args);", `
      var invokerFunction = function (obj, func, destructorsRef, packed) {
        var values = kind === 0 ? [obj] : [], at = packed;
        for (const type of types) {
          values.push(type.readValueFromPointer(at));
          at += type.argPackAdvance;
        }
        var rv = kind === 1 ? new func(...values) : func.call(...values);
        if (!retType.isVoid) return emval_returnValue(retType, destructorsRef, rv);
      };`],
];
let text = fs.readFileSync(input, "utf8");
for (const [made, closure] of closures) {
  if (text.split(made).length !== 2) throw new Error(`${input} has not exactly one '${made}'`);
  text = text.replace(made, () => closure);
}
if (/new Function\(|[^.\w]eval\(/.test(text)) throw new Error(`${input} still makes code of text`);
fs.writeFileSync(output, text);
