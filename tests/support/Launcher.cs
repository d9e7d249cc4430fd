// Runs a program and leaves at once with its exit code. Mono 6.8 stops for ever now and then when Main returns: it waits for
// threads of its pool that have ended already. A program of ten lines shows it, once in some hundred runs.
using System;
using System.Linq;
using System.Runtime.InteropServices;

public static class Launcher
{
    public static void Main(string[] arguments)
    {
        int code = 1;
        try
        {
            code = AppDomain.CurrentDomain.ExecuteAssembly(arguments[0], arguments.Skip(1).ToArray());
        }
        catch (Exception error)
        {
            Console.Error.WriteLine(error);
        }
        Console.Out.Flush();
        Console.Error.Flush();
        Leave(code);
    }

    [DllImport("libc", EntryPoint = "_exit")]
    private static extern void Leave(int code);
}
