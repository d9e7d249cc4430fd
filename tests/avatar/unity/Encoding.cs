// An engine that encodes: it sends the access units of a file, lines of base64, of which the first is a key frame and
// the other one follows it.
using System;
using System.IO;
using System.Linq;
using System.Threading;
using OpenRoIS.Link;

public static class Encoding
{
    private const int PicturesPerSecond = 25;

    public static int Main(string[] arguments)
    {
        byte[][] units = File.ReadAllLines(arguments[0]).Select(Convert.FromBase64String).ToArray();
        Hello hello = new Hello
        {
            Name = "encoding",
            Secret = Environment.GetEnvironmentVariable("OPENROIS_LINK_SECRET"),
            Width = int.Parse(arguments[1]),
            Height = int.Parse(arguments[2]),
            PicturesPerSecond = PicturesPerSecond,
            Encodes = true,
            Ring = true
        };
        using (LinkClient link = new LinkClient(Environment.GetEnvironmentVariable("OPENROIS_LINK_ADDRESS"), hello))
        {
            link.Start();
            bool isKeyFrame = true;
            while (true)
            {
                Notice notice;
                while (link.TryTake(out notice))
                {
                    isKeyFrame |= notice is KeyFrame || notice is Connected;
                    if (notice is Bitrate)
                    {
                        Console.WriteLine("bitrate " + ((Bitrate)notice).BitsPerSecond);
                    }
                    else if (notice is Quit)
                    {
                        return 0;
                    }
                }
                byte[] unit = units[isKeyFrame ? 0 : 1];
                isKeyFrame = !link.SendEncoded(unit, hello.Width, hello.Height, link.Now, isKeyFrame);
                Thread.Sleep(1000 / PicturesPerSecond);
            }
        }
    }
}
